// Two threads write one variable: ThreadSanitizer must find it.
#include <thread>

int main() {
  int shared = 0;
  std::thread other{[&shared] { shared = 1; }};
  shared = 2;
  other.join();
  return shared > 2 ? 1 : 0;
}
