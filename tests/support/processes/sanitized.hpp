// Whether this is a sanitizers' build: slower and larger, so that some figures say nothing there.
#pragma once

namespace arkmesh::tests {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace arkmesh::tests
