// sextant-mil with field-oriented control: control.controller = "own_foc".
#include "field_oriented_controller.hpp"
#include "sextant/mil/mil_program.hpp"

int main(int argc, char** argv) {
  return sextant::mil_program(argc, argv, {sextant::control_method<example::FieldOrientedController<>>()});
}
