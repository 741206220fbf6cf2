#pragma once

#include <string_view>

namespace sextant {

/// Checks that a configuration of Cyclone DDS (fragments of XML and names of files, separated by commas) is
/// well-formed. Cyclone DDS takes the end of a fragment for all the closing tags that are missing, and so
/// takes over half of a text that was cut. `</>`, which closes the innermost element of a fragment, is left
/// to it, and so are files that cannot be read. Throws std::runtime_error with the place and what is wrong,
/// in a sentence fragment.
void check_dds_configuration(std::string_view configuration);

}  // namespace sextant
