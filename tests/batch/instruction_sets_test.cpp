// One program, every processor: the same bytes without AVX, with AVX2, and with whatever this machine has.

#include "io/particle_file.h"
#include "support/planar_clouds.h"
#include "support/program.h"
#include "support/sanitized.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace betamesh {
namespace {

TEST(InstructionSets, GiveTheSameBytes) {
    if (std::system("command -v qemu-x86_64 >/dev/null") != 0) GTEST_SKIP() << "qemu-x86_64 is not installed";
    if (kSanitized) GTEST_SKIP() << "qemu and sanitizers need different memory layouts";
    const TemporaryFolder folder;
    ASSERT_EQ(runProgram({"sample", "dambreak", "d.####.ply", "--particles", "800", "--frames", "12"}, folder.path())
                  .exit_code,
              0);
    writeParticles(folder / "f.ply", randomPlanarCloud(1).particles);
    for (const std::string words : {"mesh d.0012.ply OUT.ply --skin 1.2dx --passes 2 -q -j 1",
                                    "mesh f.ply OUT.ply --radius 1 --dimension 2 --passes 2 -q -j 1"}) {
        const auto run = [&](const std::string& program, const std::string& name) {
            std::string command =
                "cd " + folder.path().string() + " && " + program + " " + words + " --overwrite 2>warnings";
            command.replace(command.find("OUT"), 3, name);
            ASSERT_EQ(std::system(command.c_str()), 0) << command;
        };
        run(BETAMESH_PROGRAM, "here");
        for (const std::string cpu : {"Nehalem", "Haswell"}) {
            // qemu does not survive a fork of a process with threads.
            run("BETAMESH_SUPERVISE=0 qemu-x86_64 -cpu " + cpu + " " + BETAMESH_PROGRAM, cpu);
            EXPECT_TRUE(contentsOf(folder / "here.ply") == contentsOf(folder / (cpu + ".ply")))
                << "on a " << cpu << ": " << words;
        }
    }
}

}  // namespace
}  // namespace betamesh
