// The HTML page of a job: what it contains, and that a browser shows it without a network.

#include "support/job_folder.h"

#include <cstdlib>
#include <regex>

namespace betamesh {
namespace {

constexpr const char* kBrowser = "/usr/bin/chromium-headless-shell";

class Report : public JobFolder {
protected:
    void SetUp() override {
        writeFrames(1, 5);
        writeFrame(3, {});
        fs::remove(folder_ / "in/a.0004.ply");
        ASSERT_EQ(mesh({"--frames", "1-5"}).exit_code, 1);
        Json jumps{{"from", "out/a.0001.ply"}, {"to", "out/a.0002.ply"}, {"max", 0.25}};
        write(folder_ / "jumps.jsonl", jumps.dump() + "\n");
        // One grey pixel.
        const std::string png =
            "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==";
        fs::create_directories(folder_ / "preview");
        ASSERT_EQ(std::system(("echo " + png + " | base64 -d > " + folder_ / "preview/a.0002.png").c_str()), 0);
        preview_ = png;
    }
    Outcome page(std::vector<std::string> further = {}) {
        further.insert(further.begin(),
                       {"report", "out/a.####.ply.json", "-o", "page.html", "--title", "A <job> & \"more\"",
                        "--coherence", "jumps.jsonl", "--previews", "preview/a.####.png"});
        return runProgram(further, folder_.path());
    }
    std::string preview_;
};

TEST_F(Report, ListsEveryFrameAndMissingOnes) {
    EXPECT_EQ(page().exit_code, 0);
    const Outcome outcome = page({"--frames", "1-5"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("no manifests of frames 4"), std::string::npos) << outcome.err;
    const std::string html = contentsOf(folder_ / "page.html");
    EXPECT_EQ(count(html, "<tr class=\"ok\">"), 3U);
    EXPECT_EQ(count(html, "<tr class=\"empty\">"), 1U);
    EXPECT_EQ(count(html, "<tr class=\"missing\"><td>4</td>"), 1U);
    EXPECT_EQ(count(html, "<svg"), 7U);
    for (const int frame : {1, 2, 5})
        EXPECT_NE(html.find("<td>" + std::to_string(report(frame)["triangles"].get<int>()) + "</td>"),
                  std::string::npos);
    EXPECT_NE(html.find("<td>0.25</td>"), std::string::npos);
    EXPECT_NE(html.find("data:image/png;base64," + preview_), std::string::npos);
    EXPECT_NE(html.find("A &lt;job> &amp; &quot;more&quot;"), std::string::npos);
    EXPECT_FALSE(std::regex_search(html, std::regex("(src|href)=.(https?:)?//|@import|<script")));
}

TEST_F(Report, RefusesFilesThatAreNotManifests) {
    EXPECT_EQ(runProgram({"report", "in/a.0001.ply", "-o", "page.html"}, folder_.path()).exit_code, 2);
    EXPECT_EQ(runProgram({"report", "out/b.0001.ply.json", "-o", "page.html"}, folder_.path()).exit_code, 2);
    const Outcome outcome = runProgram(
        {"report", "out/a.####.ply.json", "-o", "page.html", "--coherence", "in/a.0001.ply"}, folder_.path());
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("in/a.0001.ply:1: "), std::string::npos) << outcome.err;
    EXPECT_FALSE(exists("page.html"));
}

TEST_F(Report, ABrowserShowsThePage) {
    if (!fs::exists(kBrowser)) GTEST_SKIP() << kBrowser << " is not installed (docker/test-packages.txt)";
    page({"--frames", "1-5"});
    const std::string browser = std::string(kBrowser) +
                                " --no-sandbox --disable-gpu --user-data-dir=" + folder_ / "user" +
                                " --host-resolver-rules='MAP * ~NOTFOUND' ";
    const std::string url = "file://" + folder_ / "page.html";
    // The document as the browser parses it.
    ASSERT_EQ(std::system((browser + "--dump-dom " + url + " > " + folder_ / "dom 2> " + folder_ / "said").c_str()), 0)
        << contentsOf(folder_ / "said");
    const std::string dom = contentsOf(folder_ / "dom");
    EXPECT_EQ(count(dom, "<tr class="), 5U);
    EXPECT_EQ(count(dom, "</svg>"), 7U);
    EXPECT_EQ(count(dom, "<img "), 1U);
    // A screenshot that is not a single colour, and so not tiny.
    const std::string picture = folder_ / "page.png";
    ASSERT_EQ(std::system(
                  (browser + "--window-size=1200,1600 --screenshot=" + picture + ' ' + url + " 2> /dev/null").c_str()),
              0);
    EXPECT_GT(fs::file_size(picture), 20'000U);
}

}  // namespace
}  // namespace betamesh
