// Atomic output files: complete under their final name, or absent.

#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace betamesh {

/// Writes to a temporary file in the folder of the final one; commit() renames it.
///
/// The temporary is called `.<name>.<host>.<pid>.<start>.<number>.betamesh-tmp`: it is hidden, has no extension of a
/// geometry format, is different for every writer, and is recognised by sweepTemporaries(). The folder must exist. All
/// members but the destructor throw Error with the file's name and the system's reason.
class OutputFile {
public:
    explicit OutputFile(std::filesystem::path final_path);
    ~OutputFile();                            ///< removes the temporary unless it was committed
    OutputFile(OutputFile&& other) noexcept;  ///< other may only be destroyed afterwards
    OutputFile& operator=(OutputFile&&) = delete;

    void write(std::span<const std::byte> bytes);
    void write(std::string_view text);

    /// Flushes the file to the disk, renames it to the final name (replacing a file of that name) and flushes the
    /// folder.
    void commit();

    /// For libraries that open files by name: they may write to this path and must report their own errors; then
    /// commit().
    const std::filesystem::path& temporaryPath() const { return temporary_path_; }

private:
    [[noreturn]] void fail(const char* doing, int error_number) const;

    std::filesystem::path final_path_;
    std::filesystem::path temporary_path_;
    int file_ = -1;
    std::size_t unflushed_ = 0;  // bytes written since the last request to flush
};

/// Writes a whole file atomically.
void writeFile(const std::filesystem::path& path, std::string_view text);

/// Removes the temporaries in a folder that terminated processes left behind: those of this host if their process no
/// longer runs, those of other hosts if they were last written more than a day ago, both only if the writer's lock is
/// free. Does nothing if the folder does not exist. Ignores files that cannot be removed.
void sweepTemporaries(const std::filesystem::path& folder);

/// Makes the folders that files are in, where they do not exist, and sweeps them, see sweepTemporaries().
///
/// errors  the system refuses a folder
void makeFoldersOf(const std::vector<std::string>& files);

}  // namespace betamesh
