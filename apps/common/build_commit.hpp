#pragma once

namespace sextant {

/// The commit that the program was built from, as `git describe --always --dirty` names it; "unknown" where
/// the sources were built outside of a repository.
extern const char* const build_commit;

}  // namespace sextant
