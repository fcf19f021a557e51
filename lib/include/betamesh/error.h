// The exception for errors that the user can cause and fix.

#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace betamesh {

/// Thrown for everything that a user can cause. The message says where (file, frame, particle, line), what was found
/// and what was expected. Errors that only the library can cause are asserts.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Thrown for a particle that cannot be meshed. The message begins with "particle" and its row.
class ParticleError : public Error {
public:
    /// row: among the particles that were given; fault: the message after the row, such as "has pscale = 0; …".
    ParticleError(std::size_t row, const std::string& fault)
        : Error("particle " + std::to_string(row) + ' ' + fault), row_(row), fault_(fault) {}

    /// The row among the particles that were given.
    std::size_t row() const { return row_; }
    /// The message after the row.
    const std::string& fault() const { return fault_; }

private:
    std::size_t row_;
    std::string fault_;
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
