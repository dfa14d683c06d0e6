// Handlers run on a stack of their own, so that a program's stack overflow is survived, and jump back to run().
#include "sim_ode/host/turns/fault_guard.hpp"

#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <vector>

namespace arkmesh::sim_ode {

volatile int FaultGuard::in_program = 0;
volatile std::uint32_t FaultGuard::progress = 0;
volatile int FaultGuard::watches = 0;

namespace {

constexpr std::array crash_signals = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS};
constexpr int timer_signal = SIGVTALRM;
constexpr long timer_ns = 50'000'000;  // of processor time
constexpr int readings_to_hang = 20;   // one second: generous, so that it never decides a result

sigjmp_buf mark;
// Written in a handler, read after the jump.
volatile Fault::Kind why = Fault::Kind::none;
volatile int fault_signal = 0, fault_code = 0;
void* volatile fault_address = nullptr;
void* volatile fault_instruction = nullptr;
volatile bool fault_astray = false;
char fault_words[200];
volatile std::uint32_t last_progress = 0;
volatile int equal_readings = 0;
timer_t timer;  // runs periodically while `ticking`; the guard in use made it
volatile int ticking = 0;

// A signal's handler may call it.
void tick_each(long nanoseconds) {
  ticking = nanoseconds > 0;
  itimerspec every{};
  every.it_interval.tv_nsec = every.it_value.tv_nsec = nanoseconds;
  timer_settime(timer, 0, &every, nullptr);
}

void* instruction_of(void* context) {
#if defined(__x86_64__)
  return reinterpret_cast<void*>(static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RIP]);
#elif defined(__aarch64__)
  return reinterpret_cast<void*>(static_cast<ucontext_t*>(context)->uc_mcontext.pc);
#else
  return nullptr;
#endif
}

}  // namespace

struct FaultGuard::State {
  std::vector<char> stack = std::vector<char>(256 * 1024);  // handlers' own
  stack_t old_stack{};
  std::array<struct sigaction, crash_signals.size()> old_crash{};
  struct sigaction old_timer {};
};

struct FaultSignals {
  static void crash(int signal, siginfo_t* info, void* context) {
    const bool sent = info->si_code <= 0;  // by a process, perhaps this one: no instruction did it
    if (!FaultGuard::in_program || (sent && info->si_pid != getpid())) {
      // No fault of a program: the system deals with it, for a real fault when the instruction runs again.
      struct sigaction standard {};
      standard.sa_handler = SIG_DFL;
      sigaction(signal, &standard, nullptr);
      if (sent) raise(signal);
      return;
    }
    why = Fault::Kind::crash;
    fault_signal = signal;
    fault_code = info->si_code;
    fault_address = info->si_addr;
    fault_instruction = instruction_of(context);
    fault_astray = signal == SIGTRAP || fault_instruction == fault_address;
#if defined(__x86_64__)
    // a jump to nowhere: what tells is the caller, whose address lies on top of the stack
    if (signal == SIGSEGV && fault_instruction == fault_address)
      fault_instruction = reinterpret_cast<void*>(
          *reinterpret_cast<std::uintptr_t*>(static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RSP]) - 1);
#endif
    siglongjmp(mark, 1);
  }

  static void tick(int, siginfo_t*, void* context) {
    if (FaultGuard::watches == 0) return tick_each(0);
    if (!FaultGuard::in_program) return;
    if (FaultGuard::progress != last_progress) {
      last_progress = FaultGuard::progress;
      equal_readings = 0;
      return;
    }
    equal_readings = equal_readings + 1;
    if (equal_readings < readings_to_hang) return;
    equal_readings = 0;
    why = Fault::Kind::hang;
    fault_instruction = instruction_of(context);
    siglongjmp(mark, 1);
  }
};

std::shared_ptr<FaultGuard> FaultGuard::acquire() {
  static std::weak_ptr<FaultGuard> shared;
  auto guard = shared.lock();
  if (!guard) shared = guard = std::shared_ptr<FaultGuard>(new FaultGuard);
  return guard;
}

FaultGuard::FaultGuard() : state_(std::make_unique<State>()) {
  stack_t stack{};
  stack.ss_sp = state_->stack.data();
  stack.ss_size = state_->stack.size();
  sigaltstack(&stack, &state_->old_stack);

  // Nothing is blocked meanwhile, so the jump out of a handler has no mask to restore.
  struct sigaction action {};
  action.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_NODEFER | SA_RESTART;
  action.sa_sigaction = FaultSignals::crash;
  for (std::size_t k = 0; k < crash_signals.size(); ++k) sigaction(crash_signals[k], &action, &state_->old_crash[k]);
  action.sa_sigaction = FaultSignals::tick;
  sigaction(timer_signal, &action, &state_->old_timer);

  sigevent event{};
  event.sigev_notify = SIGEV_THREAD_ID;
  event.sigev_signo = timer_signal;
  event._sigev_un._tid = static_cast<pid_t>(syscall(SYS_gettid));
  if (timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &timer) != 0)
    throw std::runtime_error("the system provides no timer for watching robots' programs");
}

FaultGuard::~FaultGuard() {
  timer_delete(timer);
  ticking = 0;
  sigaction(timer_signal, &state_->old_timer, nullptr);
  for (std::size_t k = 0; k < crash_signals.size(); ++k) sigaction(crash_signals[k], &state_->old_crash[k], nullptr);
  sigaltstack(&state_->old_stack, nullptr);
}

void FaultGuard::start_ticking() {
  if (!ticking) tick_each(timer_ns);
}

Fault FaultGuard::run(void (*work)(void*), void* context) {
  why = Fault::Kind::none;
  fault_astray = false;
  equal_readings = 0;
  if (sigsetjmp(mark, 0) == 0) {
    work(context);
    return {};
  }
  leave_program();
  Fault out;
  out.kind = why;
  out.signal = fault_signal;
  out.code = fault_code;
  out.address = fault_address;
  out.instruction = fault_instruction;
  out.astray = fault_astray;
  if (out.kind == Fault::Kind::gave_up) out.words = fault_words;
  return out;
}

void FaultGuard::leave(Fault::Kind kind, const char* words, const void* instruction) {
  why = kind;
  fault_instruction = const_cast<void*>(instruction);
  fault_words[0] = 0;
  if (words) {
    std::strncpy(fault_words, words, sizeof fault_words - 1);
    fault_words[sizeof fault_words - 1] = 0;
  }
  siglongjmp(mark, 1);
}

}  // namespace arkmesh::sim_ode
