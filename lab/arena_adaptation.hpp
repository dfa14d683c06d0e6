// Until every arena says whether it is there: what the runner asks of one.
#pragma once

#include <chrono>
#include <string>

#include "hal/arena.hpp"

namespace arkmesh::lab::adapted {

template <class A>
bool advance_to(A& arena, hal::LabTime t) {
  if constexpr (requires { {arena.serve()}; })
    return arena.advance_to(t);
  else
    return arena.advance_to(t), true;
}
template <class A>
std::string waiting_for(const A& arena) {
  if constexpr (requires { arena.waiting_for(); }) return arena.waiting_for();
  return {};
}
template <class A>
bool end(A& arena) {
  if constexpr (requires { arena.end(); })
    return arena.end();
  else
    return true;
}
template <class A>
void serve(A& arena) {
  if constexpr (requires { arena.serve(); }) arena.serve();
}
template <class A>
std::chrono::steady_clock::time_point next_service(const A& arena) {
  if constexpr (requires { arena.next_service(); }) return arena.next_service();
  return std::chrono::steady_clock::time_point::max();
}
template <class A>
hal::Airtime airtime(A& link) {
  if constexpr (requires { link.airtime(); })
    return link.airtime();
  else
    return link.offer({});
}
template <class I>
double body_radius_m(const I& info) {
  if constexpr (requires { info.body_radius_m; })
    return info.body_radius_m;
  else
    return 0.0165;
}

}  // namespace arkmesh::lab::adapted
