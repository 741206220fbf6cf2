// What a drive relies on, checked on random inputs; an argument is the seed.
#include <cstdlib>

#include "field_oriented_controller.hpp"
#include "sextant/conformance/check_controller.hpp"

int main(int argc, char** argv) {
  sextant::ConformanceParameters parameters;
  if (argc > 1) parameters.seed = std::strtoull(argv[1], nullptr, 10);
  return sextant::report("own_foc",
                         sextant::check_controller<example::FieldOrientedController<>>({}, parameters));
}
