#include "io/output_file.h"

#include "io/bytes.h"
#include "support/file_checks.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <csignal>

namespace betamesh {

namespace {

namespace fs = std::filesystem;

std::size_t entriesOf(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/// Leaves the temporary of a process that terminates before commit().
void leaveTemporary(const fs::path& path) {
    const pid_t child = ::fork();
    if (child == 0) {
        OutputFile* file = new OutputFile(path);
        file->write("half");
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
}

}  // namespace

TEST(OutputFile, TheFinalNameDoesNotExistBeforeCommit) {
    const TemporaryFolder folder;
    const fs::path path = folder / "a.ply";
    {
        OutputFile file(path);
        file.write("some ");
        EXPECT_FALSE(fs::exists(path));
        const std::string name = file.temporaryPath().filename().string();
        EXPECT_EQ(name.front(), '.');
        EXPECT_EQ(file.temporaryPath().parent_path(), folder.path());
        EXPECT_EQ(file.temporaryPath().extension(), ".betamesh-tmp");
        file.write("text");
        file.commit();
    }
    EXPECT_EQ(contentsOf(path), "some text");
    EXPECT_EQ(entriesOf(folder.path()), 1U);
}

TEST(OutputFile, WithoutCommitNothingChanges) {
    const TemporaryFolder folder;
    writeFile(folder / "a.ply", "old");
    { OutputFile(folder / "a.ply").write("new"); }
    EXPECT_EQ(contentsOf(folder / "a.ply"), "old");
    EXPECT_EQ(entriesOf(folder.path()), 1U);
    writeFile(folder / "a.ply", "newer");
    EXPECT_EQ(contentsOf(folder / "a.ply"), "newer");
}

TEST(OutputFile, TwoWritersOfOneNameDoNotInterfere) {
    const TemporaryFolder folder;
    OutputFile a(folder / "a.ply");
    OutputFile b(folder / "a.ply");
    a.write("a");
    b.write("b");
    b.commit();
    a.commit();
    EXPECT_EQ(contentsOf(folder / "a.ply"), "a");
}

TEST(OutputFile, ErrorsNameTheFileAndTheReason) {
    const TemporaryFolder folder;
    expectError([&] { OutputFile(folder / "none/a.ply"); }, {"none/a.ply", "No such file"});
    writeFile(folder / "file", "x");
    expectError([&] { OutputFile(folder / "file/a.ply"); }, {"file/a.ply", "Not a directory"});
    expectError([&] { OutputFile file(folder.path()); }, {folder.path().string(), "directory"});
    if (::geteuid() != 0) {
        fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
        expectError([&] { OutputFile(folder / "a.ply"); }, {"a.ply", "Permission denied"});
        fs::permissions(folder.path(), fs::perms::owner_all);
    }
}

TEST(OutputFile, AFailedWriteLeavesNoFile) {
    const TemporaryFolder folder;
    struct rlimit before = {};
    ::getrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_IGN);
    struct rlimit small = before;
    small.rlim_cur = 1000;  // as a substitute for a full disk
    ::setrlimit(RLIMIT_FSIZE, &small);
    const std::string text = errorOf([&] { writeFile(folder / "a.ply", std::string(2000, 'x')); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_DFL);
    EXPECT_NE(text.find("a.ply"), std::string::npos) << text;
    EXPECT_NE(text.find("too large"), std::string::npos) << text;
    EXPECT_EQ(entriesOf(folder.path()), 0U);
}

TEST(OutputFile, LongNamesAreSupported) {
    const TemporaryFolder folder;
    const std::string name = std::string(251, 'n') + ".ply";
    writeFile(folder / name, "x");
    EXPECT_EQ(contentsOf(folder / name), "x");
}

TEST(OutputFile, SweepRemovesOnlyTemporariesOfTerminatedProcesses) {
    const TemporaryFolder folder;
    leaveTemporary(folder / "dead.ply");
    EXPECT_EQ(entriesOf(folder.path()), 1U);
    OutputFile mine(folder / "live.ply");
    writeFile(folder / ".hidden", "x");
    writeFile(folder / ".other.betamesh-tmp", "x");
    writeFile(folder / "a.ply", "x");
    // Temporaries of another host, written now and days ago.
    const std::string foreign = folder / ".a.ply.otherhost-1.77.5.0.betamesh-tmp";
    const std::string ancient = folder / ".a.ply.otherhost-1.78.5.0.betamesh-tmp";
    writeFile(foreign, "x");
    writeFile(ancient, "x");
    fs::last_write_time(ancient, fs::file_time_type::clock::now() - std::chrono::hours(50));

    sweepTemporaries(folder.path());
    EXPECT_TRUE(fs::exists(mine.temporaryPath()));
    EXPECT_TRUE(fs::exists(foreign));
    EXPECT_FALSE(fs::exists(ancient));
    EXPECT_EQ(entriesOf(folder.path()), 5U);
    mine.write("x");
    mine.commit();
    EXPECT_EQ(contentsOf(folder / "live.ply"), "x");
}

TEST(OutputFile, CanBeMoved) {
    const TemporaryFolder folder;
    {
        OutputFile first(folder / "a.ply");
        first.write("x");
        OutputFile second = std::move(first);
        second.write("y");
        second.commit();
    }
    EXPECT_EQ(contentsOf(folder / "a.ply"), "xy");
    { const OutputFile third = OutputFile(folder / "b.ply"); }
    EXPECT_EQ(entriesOf(folder.path()), 1U);
}

TEST(OutputFile, SweepIgnoresAMissingFolder) { EXPECT_NO_THROW(sweepTemporaries("/no/such/folder")); }

TEST(OutputFile, AReusedProcessIdIsNotTheWriter) {
    const TemporaryFolder folder;
    std::string name;
    {
        OutputFile file(folder / "a.ply");
        name = file.temporaryPath().filename().string();
    }
    // .a.ply.<host>.<pid>.<start>.<number>.betamesh-tmp, with another start time
    const std::size_t number = name.rfind('.', name.rfind('.') - 1);
    const std::size_t start = name.rfind('.', number - 1);
    const std::string other = folder / (name.substr(0, start) + ".1" + name.substr(number));
    writeFile(other, "x");
    sweepTemporaries(folder.path());
    EXPECT_FALSE(fs::exists(other));
}

}  // namespace betamesh
