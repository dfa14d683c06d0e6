// The kernel counts in one number what the filter refuses and what finds the buffer full. The two are told apart by how
// much waited: a buffer that was not even half full has lost nothing.
#include "hal/bus/multicast_receiver.hpp"

#include <linux/filter.h>
#include <linux/if_packet.h>
#include <linux/sock_diag.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

namespace arkmesh::hal {

namespace {

constexpr std::size_t datagram_bytes = 1 << 16;  // more than UDP carries
constexpr std::size_t batch_size = 32;
constexpr std::size_t datagram_overhead = 512;  // at least, of what the kernel charges for a queued datagram
constexpr unsigned loopback_interface = 1;      // Linux gives lo this index in every network namespace

void throw_if_failed(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
}

template <class Value>
void set_option(int socket, int level, int option, const Value& value, const char* what) {
  throw_if_failed(::setsockopt(socket, level, option, &value, sizeof value), what);
}

// Passes datagrams to the group which came over lo, or which are the copy that the kernel makes of a multicast datagram
// for the machine that sends it, or which come from a host to hear. A sender can forge its address, but neither of the
// first two.
std::vector<sock_filter> filter_of(const MulticastUrl& url, const std::vector<std::uint32_t>& hear) {
  constexpr sock_filter pass{BPF_RET | BPF_K, 0, 0, datagram_bytes}, refuse{BPF_RET | BPF_K, 0, 0, 0};
  constexpr auto ip_header = static_cast<std::uint32_t>(SKF_NET_OFF), about = static_cast<std::uint32_t>(SKF_AD_OFF);
  std::vector<sock_filter> filter;
  const auto load = [&](std::uint32_t at) { filter.push_back({BPF_LD | BPF_W | BPF_ABS, 0, 0, at}); };
  const auto pass_if = [&](std::uint32_t value) {
    filter.push_back({BPF_JMP | BPF_JEQ | BPF_K, 0, 1, value});
    filter.push_back(pass);
  };
  load(ip_header + 16);  // destination
  filter.push_back({BPF_JMP | BPF_JEQ | BPF_K, 1, 0, ntohl(url.group.sin_addr.s_addr)});
  filter.push_back(refuse);
  load(about + SKF_AD_IFINDEX);
  pass_if(loopback_interface);
  load(about + SKF_AD_PKTTYPE);
  pass_if(PACKET_LOOPBACK);
  load(ip_header + 12);  // source
  for (const std::uint32_t address : hear) pass_if(ntohl(address));
  filter.push_back(refuse);
  return filter;
}

// The port is LCM's, too, so the options are LCM's; the filter is there before the first datagram can be.
Handle open_socket(const MulticastUrl& url, const std::vector<std::uint32_t>& hear) {
  Handle handle(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int socket = handle.get(), on = 1;
  throw_if_failed(socket, "socket");
  auto filter = filter_of(url, hear);
  set_option(socket, SOL_SOCKET, SO_ATTACH_FILTER,
             sock_fprog{static_cast<unsigned short>(filter.size()), filter.data()}, "SO_ATTACH_FILTER");
  set_option(socket, SOL_SOCKET, SO_REUSEADDR, on, "SO_REUSEADDR");
  if (const int asked = url.receive_buffer_bytes;
      asked > 0 && ::setsockopt(socket, SOL_SOCKET, SO_RCVBUFFORCE, &asked, sizeof asked) != 0)  // root's only
    set_option(socket, SOL_SOCKET, SO_RCVBUF, asked, "SO_RCVBUF");
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = url.group.sin_port;
  throw_if_failed(::bind(socket, reinterpret_cast<const sockaddr*>(&here), sizeof here), "bind");
  set_option(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, ip_mreq{url.group.sin_addr, {}}, "IP_ADD_MEMBERSHIP");
  return handle;
}

}  // namespace

// What one system call fetches. Memory that no datagram has reached yet is not touched.
struct MulticastReceiver::Batch {
  std::size_t next = 0, size = 0;  // the next datagram to take, and how many there are
  DatagramAssembler::TimePoint fetched;
  std::array<mmsghdr, batch_size> headers{};
  std::array<iovec, batch_size> buffers{};
  std::array<sockaddr_in, batch_size> senders{};
  std::unique_ptr<std::byte[]> bytes = std::make_unique_for_overwrite<std::byte[]>(batch_size * datagram_bytes);

  Batch() {
    for (std::size_t i = 0; i < batch_size; ++i) {
      buffers[i] = {bytes.get() + i * datagram_bytes, datagram_bytes};
      headers[i].msg_hdr = {&senders[i], sizeof(sockaddr_in), &buffers[i], 1, nullptr, 0, 0};
    }
  }
};

MulticastReceiver::MulticastReceiver(const MulticastUrl& url, const std::vector<std::uint32_t>& hear)
    : socket_(open_socket(url, hear)), batch_(std::make_unique<Batch>()) {
  int bytes = 0;
  socklen_t length = sizeof bytes;
  throw_if_failed(::getsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &bytes, &length), "SO_RCVBUF");
  buffer_bytes_ = static_cast<std::size_t>(bytes);
}

MulticastReceiver::~MulticastReceiver() = default;

bool MulticastReceiver::has_fetched() const {
  return batch_->next < batch_->size;
}

bool MulticastReceiver::take(std::optional<Message>& message) {
  message.reset();
  if (!has_fetched() && !fetch()) return false;
  const std::size_t i = batch_->next++;
  const sockaddr_in& sender = batch_->senders[i];
  message = assembler_.add({sender.sin_addr.s_addr, sender.sin_port},
                           {batch_->bytes.get() + i * datagram_bytes, batch_->headers[i].msg_len}, batch_->fetched);
  return true;
}

// A batch that was not full has emptied the kernel's queue: the next call says so without a system call, and the one
// after that looks again.
bool MulticastReceiver::fetch() {
  Batch& batch = *batch_;
  const bool emptied = batch.size > 0 && batch.size < batch_size;
  batch.next = batch.size = 0;
  if (!emptied) {
    for (mmsghdr& header : batch.headers) header.msg_hdr.msg_namelen = sizeof(sockaddr_in);
    const int fetched = ::recvmmsg(socket_.get(), batch.headers.data(), batch_size, MSG_DONTWAIT, nullptr);
    batch.size = static_cast<std::size_t>(std::max(fetched, 0));
    batch.fetched = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < batch.size; ++i) backlog_bytes_ += batch.headers[i].msg_len + datagram_overhead;
  }
  if (batch.size > 0) return true;
  if (backlog_bytes_ > buffer_bytes_ / 2) count_drops();
  backlog_bytes_ = 0;
  return false;
}

// What was dropped since the last call: lost when the buffer may have been full, else refused by the filter.
void MulticastReceiver::count_drops() {
  std::array<std::uint32_t, SK_MEMINFO_VARS> info{};
  socklen_t length = sizeof info;
  if (::getsockopt(socket_.get(), SOL_SOCKET, SO_MEMINFO, info.data(), &length) != 0) return;
  const std::uint32_t dropped = info[SK_MEMINFO_DROPS] - std::exchange(drops_, info[SK_MEMINFO_DROPS]);
  if (dropped == 0) return;
  const bool was_full = backlog_bytes_ + info[SK_MEMINFO_RMEM_ALLOC] > buffer_bytes_ / 2;
  counters_.add(was_full ? "lost.receive_buffer_full" : "refused.stranger", dropped);
}

Counters MulticastReceiver::counters() {
  count_drops();
  Counters all = counters_;
  all.merge(assembler_.counters());
  return all;
}

}  // namespace arkmesh::hal
