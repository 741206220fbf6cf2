// Nothing of its own: CMake needs a source where headers are precompiled.
