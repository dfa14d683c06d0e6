// Runs robots' programs so that one that crashes or never returns ends neither the process nor the others. Process-wide
// and for one thread: signals are the process's.
#pragma once

#include <csetjmp>
#include <cstdint>
#include <memory>
#include <string>

namespace arkmesh::sim_ode {

// Why guarded work ended before its end.
struct Fault {
  enum class Kind { none, left, crash, hang, gave_up };
  Kind kind = Kind::none;
  int signal = 0;                     // crash
  int code = 0;                       // crash: si_code
  const void* address = nullptr;      // crash: what was touched
  bool astray = false;                // crash: where no code is
  const void* instruction = nullptr;  // crash, hang
  std::string words;                  // gave_up: what the program said
};

class FaultGuard {
 public:
  // Signal handlers, their stack and the timer exist while somebody holds the guard.
  static std::shared_ptr<FaultGuard> acquire();
  ~FaultGuard();
  FaultGuard(const FaultGuard&) = delete;
  FaultGuard& operator=(const FaultGuard&) = delete;

  // Calls work(context). Returns early with the fault of program code, skipping frames in between without clean-up:
  // they may own nothing. Does not nest.
  Fault run(void (*work)(void*), void* context);

  // Program code runs between these two; faults elsewhere are real ones.
  static void enter_program() {
    in_program = 1;
    progress = progress + 1;
  }
  static void leave_program() { in_program = 0; }
  // A program has given time back; it does not hang.
  static void note_progress() { progress = progress + 1; }
  // Ends run() from inside program code. `words` and `instruction` may be null.
  [[noreturn]] static void leave(Fault::Kind kind, const char* words, const void* instruction = nullptr);

  // While one lives, a program that uses the processor for a second without progress is ended. Cheap enough for each
  // advance: the timer ticks on between watches, and its next tick without one ends it.
  class Watch {
   public:
    explicit Watch(FaultGuard& guard) {
      watches = watches + 1;
      guard.start_ticking();
    }
    ~Watch() { watches = watches - 1; }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
  };

 private:
  FaultGuard();
  void start_ticking();
  static volatile int in_program;
  static volatile std::uint32_t progress;
  static volatile int watches;
  struct State;
  std::unique_ptr<State> state_;
  friend struct FaultSignals;
};

}  // namespace arkmesh::sim_ode
