// sextant-ecu with a power stage of its own: power_stage = "my_inverter".
#include "my_inverter.hpp"
#include "sextant/ecu/ecu_program.hpp"

int main(int argc, char** argv) {
  return sextant::ecu_program(argc, argv,
                              {.power_stages = {sextant::own_power_stage<example::MyInverter>()}});
}
