// main() of every test program. Both names, since the precompiled headers have doctest.h already.
#define DOCTEST_CONFIG_IMPLEMENT
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>
#include <stdlib.h>

// Compiled controllers are kept beside the tests, for them and the programs that they start, and not in the user's
// cache.
[[maybe_unused]] static const int arkmesh_test_cache = setenv("XDG_CACHE_HOME", ARKMESH_TEST_CACHE, 1);
