// Going from one stack to another. With AddressSanitizer it is told, or it takes other stacks for damage; otherwise
// this is one call of Boost.Context.
#pragma once

#include <boost/context/detail/fcontext.hpp>
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

namespace arkmesh::sim_ode {

// Lowest address and size of a stack.
struct StackBounds {
  const void* bottom = nullptr;
  std::size_t bytes = 0;
};

#if ARKMESH_ADDRESS_SANITIZER
// Before leaving for a stack, and after coming to one. The latter returns the bounds of the stack that was left.
inline void leaving_for(const StackBounds& stack) {
  __sanitizer_start_switch_fiber(nullptr, stack.bottom, stack.bytes);
}
inline StackBounds arrived() {
  StackBounds from;
  __sanitizer_finish_switch_fiber(nullptr, &from.bottom, &from.bytes);
  return from;
}
// Frames that were abandoned on a stack leave their marks.
inline void forget_frames(const StackBounds& stack) {
  ASAN_UNPOISON_MEMORY_REGION(stack.bottom, stack.bytes);
}
#else
inline void leaving_for(const StackBounds&) {}
inline StackBounds arrived() {
  return {};
}
inline void forget_frames(const StackBounds&) {}
#endif

// Returns when somebody comes back to this stack, with the context they came from.
inline void* switch_to(void* context, const StackBounds& stack, void* data) {
  leaving_for(stack);
  void* const from = boost::context::detail::jump_fcontext(context, data).fctx;
  arrived();
  return from;
}

}  // namespace arkmesh::sim_ode
