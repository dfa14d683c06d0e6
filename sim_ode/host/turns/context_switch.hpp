// Calls functions on stacks of their own, which they may leave in the middle and be resumed on. A function that damages
// its stack harms neither its caller's nor its registers. AddressSanitizer is told of each switch, or it takes other
// stacks for damage.
#pragma once

#include <cstddef>

#if defined(__SANITIZE_ADDRESS__)  // g++
#define ARKMESH_ADDRESS_SANITIZER 1
#elif defined(__has_feature)  // clang
#define ARKMESH_ADDRESS_SANITIZER __has_feature(address_sanitizer)
#else
#define ARKMESH_ADDRESS_SANITIZER 0
#endif

#if ARKMESH_ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>
#endif

extern "C" {
// Calls function(a, b) on the stack that ends at `top`, a multiple of 16, and returns what it returns, or anything when
// it leaves.
void* arkmesh_call_on(void* function, void* a, void* b, void* top);
// Inside such a function: its call returns, this one once somebody resumes what is now `*context`.
void arkmesh_leave(void** context);
// Returns when the function that left returns, or leaves again.
void arkmesh_resume(void* context);
}

namespace arkmesh::sim_ode {

// Lowest address and size of a stack.
struct StackBounds {
  void* bottom = nullptr;
  std::size_t bytes = 0;
  void* top() const { return static_cast<char*>(bottom) + bytes; }
};

#if ARKMESH_ADDRESS_SANITIZER
inline const void* callers_bottom = nullptr;
inline std::size_t callers_bytes = 0;
inline bool switching = false;

inline void leaving_for(const void* bottom, std::size_t bytes) {
  switching = true;
  __sanitizer_start_switch_fiber(nullptr, bottom, bytes);
}
inline void arrived() {
  __sanitizer_finish_switch_fiber(nullptr, nullptr, nullptr);
  switching = false;
}
inline void arrived_from_caller() {
  __sanitizer_finish_switch_fiber(nullptr, &callers_bottom, &callers_bytes);
  switching = false;
}
// Frames that were abandoned on a stack leave their marks.
inline void forget_frames(const StackBounds& stack) {
  ASAN_UNPOISON_MEMORY_REGION(stack.bottom, stack.bytes);
}
// After a jump out of a function on another stack, which abandons frames of the caller's, too.
inline void jumped_back() {
  if (switching) arrived();
  leaving_for(callers_bottom, callers_bytes);
  arrived();
  ASAN_UNPOISON_MEMORY_REGION(
      callers_bottom, static_cast<const char*>(__builtin_frame_address(0)) - static_cast<const char*>(callers_bottom));
}

struct FarCall {
  void *function, *a, *b;
#ifdef __clang__
  [[clang::no_sanitize("function")]]
#endif
  static void*
  run(void* self, void*) {
    arrived_from_caller();
    const FarCall call = *static_cast<FarCall*>(self);
    void* const result = reinterpret_cast<void* (*)(void*, void*)>(call.function)(call.a, call.b);
    leaving_for(callers_bottom, callers_bytes);
    return result;
  }
};
inline void* call_on(const StackBounds& stack, void* function, void* a, void* b) {
  FarCall call{function, a, b};
  leaving_for(stack.bottom, stack.bytes);
  void* const result = arkmesh_call_on(reinterpret_cast<void*>(FarCall::run), &call, nullptr, stack.top());
  arrived();
  return result;
}
inline void leave_for_caller(void** context) {
  leaving_for(callers_bottom, callers_bytes);
  arkmesh_leave(context);
  arrived_from_caller();
}
inline void resume_on(const StackBounds& stack, void* context) {
  leaving_for(stack.bottom, stack.bytes);
  arkmesh_resume(context);
  arrived();
}
#else
inline void forget_frames(const StackBounds&) {}
inline void jumped_back() {}
inline void* call_on(const StackBounds& stack, void* function, void* a, void* b) {
  return arkmesh_call_on(function, a, b, stack.top());
}
inline void leave_for_caller(void** context) {
  arkmesh_leave(context);
}
inline void resume_on(const StackBounds&, void* context) {
  arkmesh_resume(context);
}
#endif

}  // namespace arkmesh::sim_ode
