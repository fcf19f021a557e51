// The exception for errors that the user can cause and fix.

#pragma once

#include <stdexcept>
#include <string>

namespace betamesh {

/// Thrown for everything that a user can cause. The message says where (file, frame, particle, line), what was found
/// and what was expected. Errors that only the library can cause are asserts.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Thrown before work begins that would need more memory than there is, or than is allowed. The message says how much.
class MemoryError : public Error {
public:
    using Error::Error;
};

/// Thrown if the operating system refuses to open, read or write a file.
class FileError : public Error {
public:
    /// error_number: the value of `errno`.
    FileError(const std::string& message, int error_number) : Error(message), error_number_(error_number) {}

    /// The value of `errno`.
    int errorNumber() const { return error_number_; }

private:
    int error_number_;
};

}  // namespace betamesh
