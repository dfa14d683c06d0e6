// Found by their names when a robot's program is loaded; sim_ode/CMakeLists.txt has them exported.
#include "sim_ode/host/robot_math.hpp"

#include <dlfcn.h>

#include "hal/fixed_math.hpp"

namespace fixed = arkmesh::hal::fixed;

#define OF_ONE(name)                                 \
  extern "C" double arkmesh_fixed_##name(double x) { \
    return fixed::name(x);                           \
  }
#define OF_TWO(name)                                           \
  extern "C" double arkmesh_fixed_##name(double x, double y) { \
    return fixed::name(x, y);                                  \
  }

OF_ONE(sin)
OF_ONE(cos)
OF_ONE(tan)
OF_ONE(asin)
OF_ONE(acos)
OF_ONE(atan)
OF_ONE(sinh)
OF_ONE(cosh)
OF_ONE(tanh)
OF_ONE(exp)
OF_ONE(exp2)
OF_ONE(log)
OF_ONE(log2)
OF_ONE(log10)
OF_ONE(cbrt)
OF_TWO(atan2)
OF_TWO(pow)
OF_TWO(hypot)
#undef OF_ONE
#undef OF_TWO

namespace arkmesh::sim_ode {

bool has_robot_math() {
  return dlsym(RTLD_DEFAULT, "arkmesh_fixed_sin") == reinterpret_cast<void*>(&arkmesh_fixed_sin);
}

}  // namespace arkmesh::sim_ode
