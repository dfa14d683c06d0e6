// What robots' programs ask of the simulator: time, motors, light, chance. They call without saying for whom; it is the
// robot whose turn it is.
#pragma once

#include <cstdint>

#include "sim_ode/kilolib/robot_abi.h"

namespace arkmesh::sim_ode {

class Turns;

struct RobotServices {
  // For a program's `host`.
  static arkmesh_host all();

 private:
  static Turns& turns();
  template <class Work>
  static auto undisturbed(Work work);
  static bool receives();
  template <class Reading>
  static Reading noted(char letter, Reading reading);
  static void wait_us(std::uint32_t us, const void* from);
  static void wait_for_tick(const void* from);
  static void motors(std::uint8_t left, std::uint8_t right);
  static void colour(std::uint8_t colour);
  static std::int16_t light();
  static std::int16_t voltage();
  static std::int16_t temperature();
  static std::uint8_t random_byte();
  static void text(const char* text, std::uint32_t size);
  static void started();
  static void ended(const char* why, const void* from);
  static void busy_at(const void* from, int wakeable);
  static void jumps(const void* from);
  static void* reallocate(void* old, std::size_t size, const void* from);
  static FILE* open(const char* name, const char* mode);
  static int close(FILE* stream);
  static int write(FILE* stream, const void* data, std::size_t size);
  static int print(FILE* stream, const char* format, va_list values);
  static void say(std::uint8_t kind, std::int32_t value, const void* from);
  static std::int16_t prox(std::uint8_t sensor, const void* from);
};

}  // namespace arkmesh::sim_ode
