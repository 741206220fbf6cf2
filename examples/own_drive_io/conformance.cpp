// What a drive relies on, checked by playing a drive to the power stage.
#include "my_inverter.hpp"
#include "sextant/conformance/check_drive_io.hpp"

int main() {
  example::MyInverter::Parameters parameters;
  example::MyInverter io{parameters};
  return sextant::report("my_inverter",
                         sextant::check_drive_io<double>(
                             io, {.period_ns = parameters.basis.period_ns,
                                  .actuation_delay_periods = parameters.basis.actuation_delay_periods}));
}
