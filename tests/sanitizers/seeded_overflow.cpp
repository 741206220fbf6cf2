// Reads past the end of a heap block: AddressSanitizer must find it.
#include <vector>

int main(int argc, char**) {
  std::vector<int> values(4, argc);
  return values.data()[3 + argc];
}
