// One program, every processor: the same bytes without AVX, with AVX2, and with whatever this machine has.

#include "support/program.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace betamesh {
namespace {

TEST(InstructionSets, GiveTheSameBytes) {
    if (std::system("command -v qemu-x86_64 >/dev/null") != 0) GTEST_SKIP() << "qemu-x86_64 is not installed";
    const TemporaryFolder folder;
    ASSERT_EQ(runProgram({"sample", "dambreak", "d.####.ply", "--particles", "800", "--frames", "12"}, folder.path())
                  .exit_code,
              0);
    const std::vector<std::string> words{"mesh", "d.0012.ply", "here.ply", "--inset", "0.3dx", "--passes", "2"};
    ASSERT_EQ(runProgram(words, folder.path()).exit_code, 0);
    for (const char* cpu : {"Nehalem", "Haswell"}) {
        const std::string there = std::string(cpu) + ".ply";
        const std::string command = "cd " + folder.path().string() + " && qemu-x86_64 -cpu " + cpu + " " +
                                    BETAMESH_PROGRAM + " mesh d.0012.ply " + there +
                                    " --inset 0.3dx --passes 2 -q -j 1 2>warnings";
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
        EXPECT_TRUE(contentsOf(folder / "here.ply") == contentsOf(folder / there)) << "on a " << cpu;
    }
}

}  // namespace
}  // namespace betamesh
