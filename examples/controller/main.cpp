// sextant-mil with field-oriented control: control.controller = "own_foc".
#include <array>

#include "field_oriented_controller.hpp"
#include "sextant/mil/mil_program.hpp"

int main(int argc, char** argv) {
  const std::array own{sextant::control_method<example::FieldOrientedController<>>()};
  return sextant::mil_program(argc, argv, own);
}
