// What a robot's memory keeps of one power-up for the next.
#include <algorithm>
#include <vector>

#include "sim_ode/host/turns/distance_readings.hpp"
#include "sim_ode/host/turns/eeprom.hpp"
#include "sim_ode/host/turns/turns.hpp"

namespace arkmesh::sim_ode {

void Turns::write_eeprom(int robot) {
  if (!abi_.eeprom) return;
  memory_.start_anew();
  store_values(abi_.eeprom, bodies_.values(robot));
  store_table(abi_.eeprom, eeprom_low_gain, low_gain_table);
  store_table(abi_.eeprom, eeprom_high_gain, high_gain_table);
  memory_.copy_out(robot);
}

// Puts fresh memory in place, but for the EEPROM. The robot's values are those that its program has stored there, if it
// has one that can.
void Turns::start_anew(int robot) {
  if (abi_.eeprom_begin == abi_.eeprom_end) return memory_.start_anew();
  memory_.copy_in(robot);
  const std::vector<char> kept(abi_.eeprom_begin, abi_.eeprom_end);
  memory_.start_anew();
  std::copy(kept.begin(), kept.end(), abi_.eeprom_begin);
  if (abi_.eeprom) bodies_.store(robot, stored_values(abi_.eeprom));
}

void Turns::save(const RobotValues& values) {
  if (abi_.eeprom) store_values(abi_.eeprom, values);
}

}  // namespace arkmesh::sim_ode
