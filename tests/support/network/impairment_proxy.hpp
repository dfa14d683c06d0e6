// A TCP proxy on 127.0.0.1 that makes a network as bad as a test wants it, and proves that it did. For tests only.
// Everything may be called from any thread, at any time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace arkmesh::tests {

// All in force at once, on connections that exist and on later ones.
struct Impairment {
  std::chrono::microseconds delay{0};   // each way
  std::chrono::microseconds jitter{0};  // plus 0..jitter by chance (fixed seed); order is kept
  std::size_t bytes_per_s = 0;          // each way; 0: no limit
  std::size_t slice_bytes = 0;          // writes of at most so many bytes; 0: as they come
  std::size_t corrupt_every = 0;        // one bit of each so many-th byte is flipped, each way; 0: never
  bool swallow_to_target = false;       // black hole towards the target: taken and forgotten
  bool swallow_to_client = false;       // the same back; one of them is a half-open connection, both a black hole
  bool stall = false;                   // takes nothing any more, as a peer that does not read
  std::size_t hold_after = 0;  // stalls once so many bytes in all went to the target, until the next set(): labs then
                               // wait in mid-run for a test that is late on a busy machine; 0: never
};

class ImpairmentProxy {
 public:
  // Listens on 127.0.0.1:`port` (0: the system chooses), connects on to 127.0.0.1:`target_port`. In a thread of its
  // own; or, with `stepped`, whenever poll() is called.
  enum class Mode { thread, stepped };
  explicit ImpairmentProxy(std::uint16_t target_port, std::uint16_t port = 0, Mode mode = Mode::thread);
  ~ImpairmentProxy();
  ImpairmentProxy(const ImpairmentProxy&) = delete;
  ImpairmentProxy& operator=(const ImpairmentProxy&) = delete;

  std::uint16_t port() const;
  // Stepped mode: does what is due, waits for nothing.
  void poll();

  void set(const Impairment& impairment);
  // Ends all connections with RST.
  void reset();
  // Ends all connections with RST and refuses new ones, until refuse(false).
  void refuse(bool refused);

  // Totals since the beginning.
  struct Counts {
    std::uint64_t connections = 0;                           // accepted and joined with the target
    std::uint64_t target_refused = 0;                        // accepted, but the target was not there
    std::uint64_t resets = 0;                                // connections ended by reset() or refuse()
    std::uint64_t bytes_to_target = 0, bytes_to_client = 0;  // passed on
    std::uint64_t swallowed = 0;                             // bytes
    std::uint64_t corrupted = 0;                             // bits flipped in bytes that were passed on
    std::uint64_t writes = 0;
  };
  Counts counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arkmesh::tests
