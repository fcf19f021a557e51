// Refuses to write a file that is also read, or to write it twice.

#pragma once

#include <map>
#include <string>

namespace betamesh {

/// The files that a command reads and writes. Files are compared by their place on disk, whatever the spelling of the
/// path; files that are read also through links.
class DistinctFiles {
public:
    /// what: the role of the file for the error message, such as "the input of frame 12".
    /// errors  read: the file is one that is written. written: the file is one that is read or written
    void read(const std::string& path, const std::string& what);
    void written(const std::string& path, const std::string& what);

private:
    std::string placeOf(const std::string& path);

    std::map<std::string, std::string> folders_;             // canonical path of each folder
    std::map<std::string, std::string> read_, written_;      // place -> role
    std::map<std::string, std::string> identity_, existed_;  // device and inode of files read and written -> role
};

}  // namespace betamesh
