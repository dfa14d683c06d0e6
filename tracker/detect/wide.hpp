// Marks hot loops that may use a processor's wider instructions where it has them. Contraction is off, so the results
// are the same.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define ARKMESH_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define ARKMESH_WIDE
#endif
