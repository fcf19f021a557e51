// Files that commands must not touch, must not wait for, or must keep apart; their names; standard input and output.

#include "batch/job/distinct_files.h"
#include "batch/job/frames.h"
#include "betamesh/error.h"
#include "io/mesh_file.h"
#include "support/job_folder.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace betamesh {
namespace {

class Files : public JobFolder {
protected:
    void SetUp() override { writeFrames(1, 3); }

    /// Runs a shell command in the folder, in which $betamesh is the program. Returns its exit code.
    int shell(const std::string& command) {
        write(folder_ / "command.sh",
              "cd " + folder_.path().string() + "\nbetamesh=" BETAMESH_PROGRAM "\n" + command + '\n');
        const int status =
            std::system(("timeout 120 bash " + folder_ / "command.sh" + " 2> " + folder_ / "said").c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    std::string said() { return contentsOf(folder_ / "said"); }

    /// The program, ended with exit code 124 if it waits for ever.
    Outcome limited(const std::vector<std::string>& words) {
        RunningProgram program(words, folder_.path());
        std::thread watch([&] {
            for (int i = 0; i < 600 && !done_; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
            if (!done_) program.send(SIGTERM);
        });
        Outcome outcome = program.wait();
        done_ = true;
        watch.join();
        done_ = false;
        return outcome;
    }

private:
    std::atomic<bool> done_ = false;
};

/// Opening them could wait for ever.
TEST_F(Files, FifosSocketsAndDevicesAreRefused) {
    const std::string fifo = folder_ / "fifo.ply", socket_file = "socket.ply";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string socket_path = folder_ / socket_file;
    ASSERT_LT(socket_path.size(), sizeof address.sun_path);
    std::strcpy(address.sun_path, socket_path.c_str());
    ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    fs::create_symlink("/dev/zero", folder_ / "device.ply");
    fs::create_symlink("fifo.ply", folder_ / "fifo.vdb");
    fs::create_symlink("fifo.ply", folder_ / "fifo.vdb.ply");
    ASSERT_EQ(mesh({"--frames", "1"}).exit_code, 0);

    for (const auto& [file, kind] : {std::pair{"fifo.ply", "a FIFO (named pipe)"}, std::pair{"socket.ply", "a socket"},
                                     std::pair{"device.ply", "a device"}, std::pair{"fifo.vdb", "a FIFO"}}) {
        SCOPED_TRACE(file);
        const std::string expected = ": this is " + std::string(kind);
        const bool is_mesh = std::string(file).ends_with(".ply");
        for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
                 {"mesh", file, "x.ply"},
                 {"mesh", file, "x.ply", "--radius", "0.1"},
                 {"info", file},
                 {"render", file, "x.png", "--width", "64", "--height", "48"},
                 {"check", is_mesh ? file : "out/a.0001.ply", "--particles", is_mesh ? "in/a.0001.ply" : file},
                 {"coherence", "out/a.0001.ply", is_mesh ? file : "fifo.vdb.ply"},
                 {"run", file},
                 {"config", "print", file},
                 {"report", file, "-o", "x.html"},
                 {"coherence", "out/a.0001.ply", "out/a.0001.ply", "--plot", "x.svg", "--against", file}}) {
            const Outcome outcome = limited(words);
            EXPECT_TRUE(outcome.exit_code == 1 || outcome.exit_code == 2)
                << words[0] << outcome.exit_code << outcome.err;
            EXPECT_NE(outcome.err.find(expected), std::string::npos) << words[0] << outcome.err;
            EXPECT_NE(outcome.err.find(file), std::string::npos) << words[0] << outcome.err;
        }
    }
    // Nor are they replaced.
    ASSERT_EQ(mkfifo((folder_ / "fifo.html").c_str(), 0600), 0);
    const Outcome page = limited({"report", "out/a.0001.ply.json", "-o", "fifo.html"});
    EXPECT_EQ(page.exit_code, 2);
    EXPECT_NE(page.err.find("fifo.html: this is a FIFO"), std::string::npos) << page.err;
    EXPECT_EQ(limited({"mesh", "in/a.0001.ply", "fifo.ply", "--overwrite"}).exit_code, 1);
    EXPECT_EQ(limited({"mesh", "in/a.0001.ply", "x.ply", "--log-file", "fifo.ply"}).exit_code, 2);
    EXPECT_TRUE(fs::is_fifo(folder_ / "fifo.ply"));
    close(listener);
}

TEST_F(Files, AManifestThatIsAFifoDoesNotStopAJob) {
    ASSERT_EQ(mesh().exit_code, 0);
    fs::remove(folder_ / "out/a.0002.ply.json");
    ASSERT_EQ(mkfifo((folder_ / "out/a.0002.ply.json").c_str(), 0600), 0);
    const Outcome outcome = limited({"mesh", "in/a.####.ply", "out/a.####.ply", "--skip-existing"});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("out/a.0002.ply.json: this is a FIFO"), std::string::npos) << outcome.err;
}

/// `ulimit -f` sends SIGXFSZ, which ends a process that does not handle it.
TEST_F(Files, AFileBeyondTheSizeLimitFailsAloneAndTheOthersAreWritten) {
    writeFrames(2, 2, 60);
    ASSERT_EQ(shell("$betamesh mesh in/a.####.ply out/a.####.ply --radius 0.1 -q"), 0);
    const auto blocks = [&](int frame) { return fs::file_size(folder_ / numbered("out/a", frame, ".ply")) / 1024; };
    ASSERT_LT(blocks(2) + 1, blocks(1));
    const std::string limit = std::to_string(blocks(2) + 1);
    fs::remove_all(folder_ / "out");
    EXPECT_EQ(shell("ulimit -f " + limit + "; $betamesh mesh in/a.####.ply out/a.####.ply --radius 0.1 --io-retries 0"),
              1);
    EXPECT_TRUE(absent(1) && written(2) && absent(3)) << said();
    for (const char* file : {"out/a.0001.ply", "out/a.0003.ply"})
        EXPECT_EQ(count(said(), std::string(file) + ": cannot be written: File too large"), 1U) << said();
    EXPECT_EQ(hiddenFiles("out"), 0U);
    EXPECT_EQ(shell("ulimit -f 1; $betamesh report out/a.0002.ply.json -o x.html"), 2) << said();
    EXPECT_NE(said().find("x.html: cannot be written: File too large"), std::string::npos) << said();
}

TEST_F(Files, SamplesThatCannotBeWrittenFailAlone) {
    fs::create_directories(folder_ / "s/a.0002.ply/inside");
    const auto sample = [&](const std::string& output) {
        return runProgram({"sample", "jitter", output, "--particles", "100", "--frames", "1-3", "--overwrite"},
                          folder_.path());
    };
    const Outcome outcome = sample("s/a.####.ply");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("error: frame 2: s/a.0002.ply: cannot be written"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("2 frames written"), std::string::npos) << outcome.err;
    EXPECT_TRUE(exists("s/a.0001.ply") && exists("s/a.0003.ply"));
    write(folder_ / "file", "");
    EXPECT_EQ(sample("file/a.####.ply").exit_code, 2);
}

TEST_F(Files, NoFileIsBothReadAndWrittenOrWrittenTwice) {
    ASSERT_EQ(mesh().exit_code, 0);
    ASSERT_EQ(mesh({}, "twin/a.####.ply").exit_code, 0);
    fs::copy_file(folder_ / "in/a.0001.ply", folder_ / "in/b.spheres.ply");
    fs::copy_file(folder_ / "in/a.0001.ply", folder_ / "in/c.ply");
    fs::create_directory_symlink("in", folder_ / "link");
    fs::create_symlink("in/a.0002.ply", folder_ / "log");
    fs::create_hard_link(folder_ / "out/a.0001.ply.json", folder_ / "manifest.html");
    fs::create_hard_link(folder_ / "out/a.0002.ply", folder_ / "mesh.svg");
    fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / "particles.svg");
    write(folder_ / "job.yaml", "version: 1\ninput: {path: in/a.####.ply}\noutput: {path: new/a.####.ply}\n");
    const std::string yaml = contentsOf(folder_ / "job.yaml"), particles = contentsOf(folder_ / "in/a.0001.ply");
    const std::vector<std::string> small{"--width", "64", "--height", "48", "--overwrite"};
    const std::vector<std::vector<std::string>> refused{
        {"mesh", "in/a.####.ply", "in/a.####.ply", "--overwrite"},
        {"mesh", "in/a.####.ply", "link/a.####.ply", "--overwrite"},
        {"mesh", "in/a.####.ply", "./in/../in/a.####.ply", "--overwrite"},
        {"mesh", "in/b.spheres.ply", "in/b.ply", "--overwrite"},  // the spheres beside the mesh
        {"mesh", "in/c.ply", "new/c.ply", "--log-file", "in/c.ply"},
        {"mesh", "in/a.####.ply", "new/a.####.ply", "--log-file", "in/a.0001.ply"},
        {"mesh", "in/a.####.ply", "new/a.####.ply", "--log-file", "link/a.0001.ply"},
        {"mesh", "in/a.####.ply", "new/a.####.ply", "--log-file", "log"},
        {"mesh", "in/a.####.ply", "new/a.####.ply", "--log-file", "new/a.0003.ply"},
        {"mesh", "in/a.####.ply", "new/a.####.ply", "--log-file", "new/a.0003.ply.json"},
        {"mesh", "in/a.#.ply", "new/a.#.ply", "--log-file", "new/a.ply", "--frames", "1"},  // renamed to a.1.ply
        {"run", "job.yaml", "--log-file", "job.yaml"},
        {"render", "out/a.0001.ply", "x.png", "x.png"},
        {"render", "out/a.####.ply", "x.####.png", "--contact-sheet", "x.0002.png"},
        {"render", "out/a.####.ply", "x.####.png", "--contact-sheet", "s.png", "--movie", "s.png"},
        {"render", "out/a.0001.ply", "x.png", "--contact-sheet", "out/a.0001.ply", "--overwrite"},
        {"compare", "in/a.0001.ply", "x.png", "--contact-sheet", "in/a.0001.ply", "--overwrite"},
        {"report", "out/a.0001.ply.json", "-o", "manifest.html"},
        {"report", "out/a.####.ply.json", "-o", "manifest.html"},
        {"coherence", "out/a.####.ply", "--plot", "mesh.svg"},
        {"coherence", "out/a.####.ply", "--particles", "in/a.####.ply", "--plot", "particles.svg"},
        {"submit", "job.yaml", "--to", "openjd", "-o", "job.yaml"},
    };
    const auto before = meshesIn("in");
    for (std::vector<std::string> words : refused) {
        if (words[0] == "render" && std::find(words.begin(), words.end(), "--movie") != words.end() &&
            std::system("command -v ffmpeg > /dev/null") != 0)
            continue;
        if (words[0] == "render" || words[0] == "compare") words.insert(words.end(), small.begin(), small.end());
        std::string line;
        for (const std::string& word : words) line += word + ' ';
        SCOPED_TRACE(line);
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
        EXPECT_NE(outcome.err.find(" is both "), std::string::npos) << outcome.err;
        EXPECT_EQ(meshesIn("in"), before);
        EXPECT_FALSE(exists("new") || exists("x.png"));
    }
    EXPECT_EQ(contentsOf(folder_ / "job.yaml"), yaml);
    // Other logs are fine.
    EXPECT_EQ(runProgram({"run", "job.yaml", "--log-file", "new.log"}, folder_.path()).exit_code, 0);
    EXPECT_TRUE(exists("new/a.0003.ply") && exists("new.log"));
}

TEST_F(Files, PlotsAndPagesReplaceNoFilesOfOtherFormats) {
    ASSERT_EQ(mesh().exit_code, 0);
    const auto before = meshesIn("out");
    const std::vector<std::vector<std::string>> refused{
        {"coherence", "out/a.####.ply", "--plot", "out/a.0001.ply"},
        {"coherence", "out/a.####.ply", "--plot", "plot"},
        {"report", "out/a.####.ply.json", "-o", "out/a.0001.ply"},
        {"report", "out/a.####.ply.json", "-o", "html"},
    };
    for (const std::vector<std::string>& words : refused) {
        const Outcome outcome = runProgram(words, folder_.path());
        EXPECT_EQ(outcome.exit_code, 2) << words.back();
        EXPECT_NE(outcome.err.find(words.back() + " does not end in ."), std::string::npos) << outcome.err;
        EXPECT_EQ(meshesIn("out"), before);
    }
    EXPECT_FALSE(exists("plot") || exists("html"));
}

TEST_F(Files, DistinctFilesKnowsAFileByAnyPath) {
    fs::create_directory_symlink("in", folder_ / "link");
    fs::create_hard_link(folder_ / "in/a.0001.ply", folder_ / "hard.ply");
    DistinctFiles files;
    files.read(folder_ / "in/a.0001.ply", "an input");
    files.read(folder_ / "link/a.0001.ply", "an input again");  // reading twice harms nobody
    EXPECT_THROW(files.written(folder_ / "link/a.0001.ply", "an output"), Error);
    EXPECT_THROW(files.written(folder_ / "hard.ply", "an output"), Error);
    EXPECT_THROW(files.written(folder_ / "in/./../in/a.0001.ply", "an output"), Error);
    files.written(folder_ / "no/such/folder/b.ply", "an output");
    EXPECT_THROW(files.written(folder_ / "no/such/other/../folder/b.ply", "another output"), Error);
    EXPECT_THROW(files.read(folder_ / "no/such/folder/b.ply", "an input"), Error);
    files.written(folder_ / "no/such/folder/c.ply", "another output");
}

TEST_F(Files, PathsOfAnyBytesResume) {
    for (const std::string& name : {std::string("\xff\xfe"), std::string("a\x1b[31mb"), std::string("100% \"\\ '"),
                                    std::string("\xc3\xa4"), std::string("line\nbreak"), std::string("\xc3")}) {
        SCOPED_TRACE(name);
        const std::string folder = folder_ / name;
        fs::create_directories(folder);
        fs::copy_file(folder_ / "in/a.0001.ply", folder + '/' + name + ".0001.ply");
        const std::vector<std::string> words{"mesh",
                                             folder + '/' + name + ".####.ply",
                                             folder + "/m" + name + ".####.ply",
                                             "--skip-existing",
                                             "--json",
                                             "--droplets",
                                             "points"};
        const Outcome first = runProgram(words, folder_.path());
        ASSERT_EQ(first.exit_code, 0) << first.err;
        ASSERT_EQ(jsonLines(first.out).size(), 1U) << first.out;
        EXPECT_EQ(jsonLines(first.out)[0]["status"], "ok");
        EXPECT_EQ(first.out.find('\x1b'), std::string::npos);
        for (const char c : first.err) EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << first.err;
        EXPECT_EQ(count(first.err, "\n"), count(first.err, " info: ") + count(first.err, " warning: ")) << first.err;
        const Outcome second = runProgram(words, folder_.path());
        EXPECT_EQ(jsonLines(second.out).at(0)["status"], "skipped") << second.out << second.err;
    }
}

/// Attributes and comments named with escape sequences, which a terminal would carry out.
TEST_F(Files, ControlCharactersInFilesDoNotReachTheTerminal) {
    const std::string evil =
        "evil\x1b]0;title\x07\x1b[2J\xc2\x9b"
        "31m\x7f";
    std::string text = "ply\nformat ascii 1.0\ncomment " + evil + "\nelement vertex 8\n";
    for (const char* axis : {"x", "y", "z"}) text += std::string("property float ") + axis + '\n';
    text += "property float " + evil + "\nend_header\n";
    for (int i = 0; i < 8; ++i)
        text += std::to_string(i % 2) + ' ' + std::to_string(i / 2 % 2) + ' ' + std::to_string(i / 4) + " 0\n";
    write(folder_ / "evil.ply", text);
    write(folder_ / ("x" + evil + ".ply"), text + "1");
    write(folder_ / ("x" + evil + ".yaml"), "version: 1\n" + std::string("\"") + "a\\e[2Jb\": 1\n");
    const std::vector<std::vector<std::string>> commands{
        {"info", "evil.ply"},
        {"info", "--json", "evil.ply"},
        {"info", "x" + evil + ".ply"},
        {"check", "x" + evil + ".ply"},
        {"check", "--json", "x" + evil + ".ply"},
        {"mesh", "evil.ply", "m" + evil + ".ply"},
        {"mesh", "evil.ply", "m2.ply", "--attributes", "absent"},
        {"mesh", "evil.ply", "m" + evil + ".ply", "--dry-run", "--overwrite"},
        {"mesh", "evil.ply", "m" + evil + ".plx"},
        {"mesh", "evil.ply", "m.ply", "--" + evil},
        {"coherence", "m" + evil + ".ply", "m" + evil + ".ply"},
        {evil},
        {"run", "x" + evil + ".yaml"},
        {"config", "check", "x" + evil + ".yaml"},
        {"sample", evil, "a.ply"},
        {"report", "m" + evil + ".ply.json", "-o", evil + ".html"},
        {"render", "x" + evil + ".ply", evil + ".png"},
    };
    for (const std::vector<std::string>& words : commands) {
        SCOPED_TRACE(words[0]);
        const Outcome outcome = runProgram(words, folder_.path());
        for (const std::string& stream : {outcome.out, outcome.err}) {
            for (const char c : stream)
                EXPECT_TRUE(c == '\n' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f)) << int{c};
            EXPECT_EQ(stream.find("\xc2\x9b"), std::string::npos) << stream;
        }
        const bool is_json = std::find(words.begin(), words.end(), "--json") != words.end();
        if (is_json) {
            for (const Json& line : jsonLines(outcome.out)) EXPECT_FALSE(line.is_discarded()) << outcome.out;
        }
    }
    EXPECT_NE(runProgram({"info", "evil.ply"}, folder_.path()).out.find("evil\\x1b]0;title"), std::string::npos);
}

TEST_F(Files, DashIsStandardInputAndOutput) {
    ASSERT_EQ(
        shell("$betamesh mesh in/a.0001.ply whole.ply -q && $betamesh mesh in/a.0001.ply whole.bgeo -q && "
              "$betamesh sample jitter s.bgeo --particles 300 -q && $betamesh sample jitter s.vdb --particles 300 -q"),
        0);
    ASSERT_EQ(shell("$betamesh mesh - - < in/a.0001.ply > piped.ply"), 0) << said();
    EXPECT_EQ(contentsOf(folder_ / "piped.ply"), contentsOf(folder_ / "whole.ply"));
    EXPECT_NE(said().find(" info: "), std::string::npos);
    ASSERT_EQ(shell("cat in/a.0001.ply | $betamesh mesh - - --format bgeo | cat > piped.bgeo"), 0) << said();
    EXPECT_EQ(contentsOf(folder_ / "piped.bgeo"), contentsOf(folder_ / "whole.bgeo"));
    ASSERT_EQ(shell("$betamesh mesh - out.ply < in/a.0001.ply"), 0) << said();
    EXPECT_EQ(contentsOf(folder_ / "out.ply"), contentsOf(folder_ / "whole.ply"));
    ASSERT_EQ(shell("$betamesh mesh in/a.0001.ply - --progress tractor > out2.ply"), 0) << said();
    EXPECT_EQ(contentsOf(folder_ / "out2.ply"), contentsOf(folder_ / "whole.ply"));
    EXPECT_NE(said().find("TR_PROGRESS 100%"), std::string::npos) << said();
    // Formats are told apart by contents; a mesh has the format of the particles, or .ply.
    ASSERT_EQ(shell("$betamesh mesh - - < s.bgeo > from.bgeo && $betamesh mesh - - < s.vdb > from.ply"), 0) << said();
    EXPECT_FALSE(readMesh(folder_ / "from.bgeo").triangles.empty());
    EXPECT_FALSE(readMesh(folder_ / "from.ply").triangles.empty());
    EXPECT_EQ(shell("$betamesh mesh - - < in/a.0001.ply 2> /dev/null | $betamesh check - > report"), 0) << said();
    EXPECT_NE(contentsOf(folder_ / "report").find("stdin.ply: good"), std::string::npos);
    EXPECT_EQ(shell("$betamesh info - < s.vdb > report"), 0) << said();
    ASSERT_EQ(shell("$betamesh convert s.vdb s.csv && $betamesh convert - - --format csv < s.vdb > piped.csv"), 0)
        << said();
    EXPECT_EQ(contentsOf(folder_ / "piped.csv"), contentsOf(folder_ / "s.csv"));
    ASSERT_EQ(shell("$betamesh convert - - < s.bgeo > again.bgeo"), 0) << said();
    EXPECT_EQ(contentsOf(folder_ / "again.bgeo"), contentsOf(folder_ / "s.bgeo"));
    EXPECT_EQ(shell("$betamesh convert - - --format obj < s.bgeo > wrong"), 1);  // particles, not a mesh
    EXPECT_EQ(shell("$betamesh convert s.bgeo x.ply --format ply"), 2);
}

TEST_F(Files, StandardStreamsLeaveNothingBehindAndRefuseWhatTheyCannotDo) {
    fs::create_directory(folder_ / "tmp");
    write(folder_ / "noise", "no geometry at all");
    const auto expect = [&](int exit_code, const std::string& command, const std::string& error) {
        SCOPED_TRACE(command);
        EXPECT_EQ(shell("export TMPDIR=$PWD/tmp\n$betamesh " + command + " > stdout"), exit_code) << said();
        EXPECT_NE(said().find(error), std::string::npos) << said();
        EXPECT_EQ(said().find("tmp/betamesh-"), std::string::npos) << said();
        EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
        if (exit_code != 0) {
            EXPECT_EQ(contentsOf(folder_ / "stdout"), "");
        }
    };
    expect(0, "mesh - - < in/a.0001.ply", "");
    expect(0, "mesh in/a.0001.ply - --droplets points --droplet-particles 9999",
           "spheres beside the mesh are left out");
    expect(2, "mesh - - < noise", "stdin has an unknown format");
    expect(2, "mesh - - < /dev/null", "stdin is empty");
    expect(2, "mesh - - --json < in/a.0001.ply", "--json prints on stdout");
    expect(2, "mesh - - --dry-run < in/a.0001.ply", "--dry-run prints on stdout");
    expect(1, "mesh - - --attributes absent < in/a.0001.ply", "stdin.ply: the particles have no attribute 'absent'");
    expect(2, "mesh - - --radius 0 < in/a.0001.ply", "--radius");
    expect(2, "check - - < in/a.0001.ply", "stdin (-) is named twice");
    // Nothing names the file in the temporary folder: neither text nor JSON nor the manifest.
    ASSERT_EQ(shell("$betamesh mesh in/a.0001.ply mesh.ply -q"), 0) << said();
    const auto expectOnStdout = [&](int exit_code, const std::string& command, const std::string& line) {
        expect(exit_code, command, "");
        EXPECT_NE(contentsOf(folder_ / "stdout").find(line), std::string::npos) << contentsOf(folder_ / "stdout");
        EXPECT_EQ(contentsOf(folder_ / "stdout").find("betamesh-"), std::string::npos);
    };
    expectOnStdout(0, "check - < mesh.ply", "stdin.ply: good");
    expectOnStdout(0, "check - --json < mesh.ply", R"("file":"stdin.ply")");
    expectOnStdout(0, "info - < mesh.ply", "stdin.ply\n");
    expectOnStdout(0, "info - --json < mesh.ply", R"("file":"stdin.ply")");
    expectOnStdout(0, "mesh - dry.ply --dry-run < in/a.0001.ply", "stdin.ply -> dry.ply");
    expectOnStdout(0, "mesh - piped.ply --json < in/a.0001.ply", R"("input":"stdin.ply")");
    EXPECT_NE(contentsOf(folder_ / "piped.ply.json").find(R"("input":"stdin.ply")"), std::string::npos);
    ASSERT_EQ(shell(R"(mkdir 'q"\t'; export TMPDIR=$PWD/'q"\t'; $betamesh info - --json < mesh.ply > stdout)"), 0);
    EXPECT_NE(contentsOf(folder_ / "stdout").find(R"("file":"stdin.ply")"), std::string::npos);
    ASSERT_EQ(shell("mkdir t\xff; export TMPDIR=$PWD/t\xff; $betamesh info - --json < mesh.ply > stdout"), 0);
    EXPECT_EQ(contentsOf(folder_ / "stdout").find("betamesh-"), std::string::npos) << contentsOf(folder_ / "stdout");
    ASSERT_EQ(shell("export TMPDIR=$PWD/absent; $betamesh info - < mesh.ply"), 2);
    EXPECT_NE(said().find("the folder for temporary files, TMPDIR, does not exist"), std::string::npos) << said();
    ASSERT_EQ(shell("head -c 300 in/a.0001.ply | $betamesh check - --json > stdout"), 1) << said();
    EXPECT_NE(contentsOf(folder_ / "stdout").find(R"("error":"stdin.ply: )"), std::string::npos);
    for (const char* command : {"mesh in/a.0001.ply -", "convert in/a.0001.ply -", "info in/a.0001.ply"}) {
        EXPECT_EQ(shell("$betamesh " + std::string(command) + " > /dev/full"), 1) << command << said();
        EXPECT_NE(said().find("stdout cannot be written"), std::string::npos) << said();
    }
}

/// What a run refuses, a dry run refuses with the same exit code, and it writes nothing.
TEST_F(Files, ADryRunFindsWhatTheRunFinds) {
    ASSERT_EQ(mesh({"--frames", "2"}).exit_code, 0);
    write(folder_ / "plain", "a file, no folder");
    fs::create_directory(folder_ / "closed");
    struct Case {
        std::vector<std::string> options;
        const char* output;
        int exit_code;
    };
    const std::vector<Case> cases{
        {{}, "new/a.####.ply", 0},
        {{}, "out/a.####.ply", 2},  // exists
        {{"--skip-existing"}, "out/a.####.ply", 0},
        {{}, "plain/a.####.ply", 2},
        {{}, "plain/below/a.####.ply", 2},
        {{"--attributes", "absent"}, "new/a.####.ply", 1},
        {{"--velocity", "absent"}, "new/a.####.ply", 1},
        {{"--id", "absent"}, "new/a.####.ply", 1},
        {{"--skin", "5"}, "new/a.####.ply", 2},  // in world units, so that only the measured radius tells
        {{"--skin", "1.6dx"}, "new/a.####.ply", 2},
        {{"--radius", "1e38dx", "--spacing", "100"}, "new/a.####.ply", 2},
        {{"--frames", "1-9"}, "new/a.####.ply", 1},  // missing inputs
        {{}, "in/a.####.ply", 2},
        {{}, "new/a.ply", 2},
        {{"--dimension", "2"}, "new/a.####.ply", 1},  // the particles are not in one plane
    };
    for (const Case& one : cases) {
        std::string line = one.output;
        for (const std::string& option : one.options) line += ' ' + option;
        SCOPED_TRACE(line);
        std::vector<std::string> options = one.options;
        options.push_back("--dry-run");
        const Outcome dry = mesh(options, one.output);
        EXPECT_EQ(dry.exit_code, one.exit_code) << dry.err;
        EXPECT_FALSE(exists("new"));
        const Outcome real = mesh(one.options, one.output);
        EXPECT_EQ(real.exit_code, one.exit_code) << real.err;
        if (one.exit_code != 0) {
            EXPECT_TRUE(dry.err.find(" error: ") != std::string::npos || dry.out.find("fail (") != std::string::npos);
        }
        fs::remove_all(folder_ / "new");
    }
}

TEST_F(Files, ThreadsBeyondThoseOfTheMachineAreNotStarted) {
    const auto begin = std::chrono::steady_clock::now();
    const Outcome outcome = mesh({"-j", "4096", "--frames", "1", "-v"});
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(kSanitized ? 120 : 15));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("run.threads is 4096, but this process may use "), std::string::npos) << outcome.err;
    EXPECT_EQ(mesh({"-j", "2", "--frames", "2"}).err.find("run.threads"), std::string::npos);
}

TEST_F(Files, LengthsThatFloatsCannotStoreAreRefused) {
    for (const char* value : {"1e39", "1e300", "1e-46", "1e-300", "inf", "nan", "-1"})
        for (const char* option : {"--radius", "--spacing", "--skin", "--smoothing-width", "--bubble-gap"}) {
            SCOPED_TRACE(std::string(option) + ' ' + value);
            const Outcome outcome = mesh({option, value, "--frames", "1"});
            EXPECT_EQ(outcome.exit_code, 2);
            EXPECT_NE(outcome.err.find(std::string("'") + value + "' is not valid"), std::string::npos) << outcome.err;
            EXPECT_EQ(count(outcome.err, "32-bit floats"), std::string(value).starts_with("1e") ? 1U : 0U)
                << outcome.err;
        }
    for (const char* option : {"--scale", "--velocity-scale", "--time-scale"})
        EXPECT_EQ(mesh({option, "1e39", "--frames", "1"}).exit_code, 2) << option;
    for (const char* option : {"--camera-position", "--look-at"})
        EXPECT_EQ(runProgram({"render", "in/a.0001.ply", "x.png", option, "0,1e39,0"}, folder_.path()).exit_code, 2);
    EXPECT_EQ(mesh({"--radius", "1e38dx", "--spacing", "100", "--frames", "1"}).exit_code, 2);
    for (const char* radius : {"1e19", "1e30", "2e37"}) {
        SCOPED_TRACE(radius);
        ASSERT_EQ(mesh({"--radius", radius, "--spacing", radius, "--frames", "1", "--overwrite"}).exit_code, 0);
        EXPECT_EQ(runProgram({"check", "out/a.0001.ply"}, folder_.path()).exit_code, 0);
    }
}

/// The sum of a position and a radius may not fit, although both do.
TEST_F(Files, PositionsBeyondFloatsFailTheFrame) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (int i = 0; i < 8; ++i)
        text += std::string(i % 2 ? "3.3e38 " : "3e38 ") + (i / 2 % 2 ? "1e37 " : "0 ") + (i / 4 ? "1e37\n" : "0\n");
    write(folder_ / "far.ply", text);
    const Outcome outcome =
        runProgram({"mesh", "far.ply", "far.mesh.ply", "--radius", "3e37", "--skin", "none", "--surface", "union"},
                   folder_.path());
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_NE(outcome.err.find("beyond the range of the 32-bit floats"), std::string::npos) << outcome.err;
    EXPECT_FALSE(exists("far.mesh.ply"));
}

TEST_F(Files, FoldersOfOutputsAreMadeByEveryCommand) {
    const auto expect = [&](const std::string& command, const std::string& output) {
        EXPECT_EQ(shell("$betamesh " + command), 0) << command << said();
        EXPECT_TRUE(exists(output)) << command << said();
    };
    expect("convert in/a.####.ply 'c.####/c.####.csv'", "c.0002/c.0002.csv");
    expect("sample drop 's.####/s.####.ply' --particles 300 --frames 1-2", "s.0002/s.0002.ply");
    expect("mesh in/a.####.ply 'm.####/m.####.ply'", "m.0002/m.0002.ply");
    expect("render in/a.####.ply 'r.####/r.####.png' --width 32 --height 32 --samples 1", "r.0002/r.0002.png");
    for (const char* command :
         {"convert in/a.0001.ply '$OUT/o.csv'", "sample drop '$OUT/o.ply' --particles 300",
          "mesh in/a.0001.ply '$OUT/o.ply'", "render in/a.0001.ply '$OUT/o.png' --width 32 --height 32 --samples 1"}) {
        const std::string name = std::string("folder_of_") + command[0];
        EXPECT_EQ(shell("export OUT=" + name + "/deep\n$betamesh " + command), 0) << command << said();
        EXPECT_FALSE(fs::is_empty(folder_ / (name + "/deep"))) << command;
    }
    EXPECT_FALSE(exists("$OUT") || exists("c.####") || exists("s.####"));
    write(folder_ / "file", "");
    for (const char* command : {"convert in/a.0001.ply file/o.csv", "sample drop file/o.ply --particles 300",
                                "render in/a.0001.ply file/o.png --width 32 --height 32 --samples 1"}) {
        EXPECT_NE(shell(std::string("$betamesh ") + command), 0);
        for (const char* part : {"'file': ", "folder", ": Not a directory"})
            EXPECT_NE(said().find(part), std::string::npos) << said();
    }
}

TEST(FrameNames, StandForTheFilesOnDisk) {
    const TemporaryFolder folder;
    for (const char* name : {"a.0001.ply", "a.0003.ply", "b#.ply", "a.3.ply"}) write(folder / name, "");
    EXPECT_EQ(filesNamed({folder / "a.####.ply", folder / "b#.ply", folder / "absent.ply"}),
              (std::vector<std::string>{folder / "a.0001.ply", folder / "a.0003.ply", folder / "b#.ply",
                                        folder / "absent.ply"}));
    EXPECT_THROW(filesNamed({folder / "c.####.ply"}), Error);
    const FramePattern pattern = framePattern("x/a.####.ply");
    for (const char* frame : {"x/a.0012.ply", "x/a.-012.ply", "x/../x/a.0007.ply"})
        EXPECT_TRUE(isFrameOf(pattern, frame)) << frame;
    for (const char* other :
         {"x/a.12.ply", "x/a..ply", "x/a.0012.plyx", "x/b.0012.ply", "x/a.0x12.ply", "a.0012.ply", ""})
        EXPECT_FALSE(isFrameOf(pattern, other)) << other;
}

}  // namespace
}  // namespace betamesh
