#include "sextant/mil/mil_program.hpp"

int main(int argc, char** argv) {
  return sextant::mil_program(argc, argv);
}
