// Receives the messages of a network bus in place of LCM's own receiver, which trusts every datagram and hears
// whoever reaches its port. Hears what this machine sent to the group, and named hosts of the network; the kernel
// drops all else before it is queued. Shares the port with LCM's programs (lcm-logger, lcm-spy). No thread.
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "hal/bus/datagram_assembler.hpp"
#include "hal/bus/multicast_url.hpp"
#include "hal/counters.hpp"
#include "hal/handle.hpp"

namespace arkmesh::hal {

class MulticastReceiver {
 public:
  using Message = DatagramAssembler::Message;

  // `hear`: the hosts that are heard beside this machine, by IPv4 address in network order. Throws std::system_error.
  MulticastReceiver(const MulticastUrl& url, const std::vector<std::uint32_t>& hear);
  ~MulticastReceiver();

  // Takes one datagram and the message that it completes, which lives until the next call. False when none waits.
  bool take(std::optional<Message>& message);

  // Datagrams were fetched and not taken yet; descriptor() does not tell of them.
  bool has_fetched() const;
  // Readable while datagrams wait that were not fetched yet.
  int descriptor() const { return socket_.get(); }
  // Of the receive buffer, as the kernel measures: it grants twice what is asked for.
  std::size_t buffer_bytes() const { return buffer_bytes_; }
  // What was refused or lost, up to now.
  Counters counters();

 private:
  struct Batch;
  bool fetch();
  void count_drops();

  Handle socket_;
  std::size_t buffer_bytes_ = 0;
  std::unique_ptr<Batch> batch_;
  DatagramAssembler assembler_;
  std::size_t backlog_bytes_ = 0;  // fetched since the kernel's queue was empty last, with the kernel's overhead
  std::uint32_t drops_ = 0;        // of the kernel, counted so far
  Counters counters_;
};

}  // namespace arkmesh::hal
