#include "sextant/ecu/ecu_program.hpp"

int main(int argc, char** argv) {
  return sextant::ecu_program(argc, argv);
}
