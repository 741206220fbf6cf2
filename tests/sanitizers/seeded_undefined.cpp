// Overflows a signed integer: UndefinedBehaviorSanitizer must find it.
#include <limits>

int main(int argc, char**) {
  volatile int largest = std::numeric_limits<int>::max();
  largest = largest + argc;
  return 0;
}
