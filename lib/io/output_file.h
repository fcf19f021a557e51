// Files that are either complete or absent.

#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace betamesh {

/// A file under a temporary name in the folder of its final one, which it takes when committed.
///
/// The temporary is called `.<name>.<host>.<pid>.<start>.<number>.betamesh-tmp`: hidden, without a format's
/// extension, different for every writer, and recognisable by sweepTemporaries(). The folder must exist. All members
/// but the destructor throw Error with the file's name and the system's reason.
class OutputFile {
public:
    explicit OutputFile(std::filesystem::path final_path);
    ~OutputFile();                            ///< removes the temporary unless committed
    OutputFile(OutputFile&& other) noexcept;  ///< what is left of the other does nothing any more
    OutputFile& operator=(OutputFile&&) = delete;

    void write(std::span<const std::byte> bytes);
    void write(std::string_view text);

    /// Flushes to the disk, takes the final name (replacing what stood there), flushes the folder.
    void commit();

    /// For libraries that open files by name themselves: they may write here (and must tell of their own
    /// errors), then commit().
    const std::filesystem::path& temporaryPath() const { return temporary_path_; }

private:
    [[noreturn]] void fail(const char* doing, int error_number) const;

    std::filesystem::path final_path_;
    std::filesystem::path temporary_path_;
    int file_ = -1;
    std::size_t waiting_ = 0;  // bytes that nobody has asked the disk to take
};

/// Writes a whole file at once, or nothing.
void writeFile(const std::filesystem::path& path, std::string_view text);

/// Removes temporaries that ended processes left in a folder, and none of a live process: those of this host
/// when the process is gone, those of other hosts when they were last written more than a day ago; either only
/// when nobody holds the writer's lock. A folder that does not exist has none. Never throws for what it cannot
/// remove.
void sweepTemporaries(const std::filesystem::path& folder);

}  // namespace betamesh
