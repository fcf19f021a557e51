// What went wrong, in words for the person who can mend it.

#pragma once

#include <stdexcept>
#include <string>

namespace betamesh {

/// Thrown for everything a user can cause. The text says where (file, frame, particle, line), what was
/// found and what was expected. Mistakes that only the library can make are asserts.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace betamesh
