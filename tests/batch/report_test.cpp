// The HTML page of a job: what it contains, and that a browser shows it without a network.

#include "support/job_folder.h"

#include "betamesh/version.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <regex>
#include <set>

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
                       {"report", "out/a.####.ply.json", "-o", "web/page.html", "--title", "A <job> & \"more\"",
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
    const std::string html = contentsOf(folder_ / "web/page.html");
    EXPECT_EQ(count(html, "<tr class=\"ok\">"), 3U);
    EXPECT_EQ(count(html, "<tr class=\"empty\">"), 1U);
    EXPECT_EQ(count(html, "<tr class=\"missing\"><td>4</td>"), 1U);
    EXPECT_EQ(count(html, "<svg"), 7U);
    for (const int frame : {1, 2, 5})
        EXPECT_NE(html.find("<td>" + std::to_string(manifest(frame)["triangles"].get<int>()) + "</td>"),
                  std::string::npos);
    EXPECT_NE(html.find("<td>0.25</td>"), std::string::npos);
    EXPECT_NE(html.find("data:image/png;base64," + preview_), std::string::npos);
    EXPECT_NE(html.find("A &lt;job> &amp; &quot;more&quot;"), std::string::npos);
    EXPECT_FALSE(std::regex_search(html, std::regex("(src|href)=.(https?:)?//|@import|<script")));
}

TEST_F(Report, ShowsEachOutputWithItsSettings) {
    write(folder_ / "job.yaml",
          "version: 1\npreset: sph\ninput: {path: in/a.####.ply}\nframes: 1-3\noutputs:\n"
          "- {path: 'fine <&\"/a.####.ply'}\n- {path: rough/a.####.ply, surface: {radius: 0.25, spacing: 0.125}}\n");
    const Outcome run = runProgram({"run", "job.yaml"}, folder_.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
    fs::remove(folder_ / "rough/a.0002.ply.json");
    const auto reported = [&](const std::vector<std::string>& manifests) {
        std::vector<std::string> words{"report", "-o", "two.html", "--frames", "1-3"};
        words.insert(words.end(), manifests.begin(), manifests.end());
        return runProgram(words, folder_.path());
    };
    const Outcome outcome = reported({"fine <&\"/a.####.ply.json", "rough/a.####.ply.json"});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("no manifests of frames 2 of rough/a.####.ply."), std::string::npos) << outcome.err;
    const std::string html = contentsOf(folder_ / "two.html");
    EXPECT_EQ(count(html, "<h2>fine &lt;&amp;&quot;/a.####.ply</h2>"), 1U) << html.substr(0, 6000);
    EXPECT_EQ(count(html, "<h2>rough/a.####.ply</h2>"), 1U);
    EXPECT_EQ(count(html, "<table>"), 2U);
    EXPECT_EQ(count(html, "<tr class=\"missing\"><td>2</td>"), 1U);
    for (const char* row : {"<dt>Input</dt><dd>in/a.####.ply</dd>", "<dt>Preset</dt><dd>sph</dd>",
                            "<dt>Program</dt><dd>betamesh " BETAMESH_VERSION "</dd>", "<dt>Dimension</dt><dd>3</dd>"})
        EXPECT_EQ(count(html, row), 2U) << row;
    for (const char* row : {"<dt>Radius</dt><dd>0.25 world units (2 spacings)</dd>",
                            "<dt>Spacing</dt><dd>0.125 world units</dd>", "<dt>Missing frames</dt><dd>2</dd>"})
        EXPECT_EQ(count(html, row), 1U) << row;
    const double skin = Json::parse(contentsOf(folder_ / "rough/a.0001.ply.json"))["skin"].get<double>();
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "<dt>Skin</dt><dd>%.6g world units", skin);
    EXPECT_NE(html.find(text.data()), std::string::npos) << text.data();
    // Single manifests are sorted into outputs by the names of their meshes.
    EXPECT_EQ(reported({"rough/a.0003.ply.json", "fine <&\"/a.0001.ply.json", "rough/a.0001.ply.json"}).exit_code, 1);
    EXPECT_EQ(count(contentsOf(folder_ / "two.html"), "<table>"), 2U);
    // An output without any manifest is shown if its frames are known, and otherwise an error.
    EXPECT_EQ(reported({"rough/a.####.ply.json", "lost/a.####.ply.json"}).exit_code, 1);
    EXPECT_EQ(count(contentsOf(folder_ / "two.html"), "<tr class=\"missing\">"), 4U);
    EXPECT_EQ(runProgram({"report", "lost/a.####.ply.json", "-o", "x.html"}, folder_.path()).exit_code, 2);
}

TEST_F(Report, ShowsCurves) {
    ASSERT_EQ(
        runProgram({"sample", "puddle", "pud/p.####.ply", "--particles", "300", "--frames", "1-2"}, folder_.path())
            .exit_code,
        0);
    ASSERT_EQ(runProgram({"mesh", "pud/p.####.ply", "curves/p.####.ply", "--dimension", "2"}, folder_.path()).exit_code,
              0);
    ASSERT_EQ(runProgram({"report", "curves/p.####.ply.json", "-o", "c.html"}, folder_.path()).exit_code, 0);
    const std::string html = contentsOf(folder_ / "c.html");
    const Json manifest = Json::parse(contentsOf(folder_ / "curves/p.0001.ply.json"));
    EXPECT_GT(manifest["edges"].get<int>(), 0);
    EXPECT_NE(html.find("<td>" + std::to_string(manifest["edges"].get<int>()) + "</td>"), std::string::npos);
    EXPECT_NE(html.find("<th>length</th>"), std::string::npos);
    EXPECT_NE(html.find("<dt>Dimension</dt><dd>2</dd>"), std::string::npos);
    EXPECT_EQ(html.find("triangles"), std::string::npos);
}

/// The labels of the vertical axis of the plot with this title.
std::vector<std::string> labelsOf(const std::string& html, const std::string& title) {
    const std::size_t begin = html.rfind("<svg", html.find(">" + title + "<")), end = html.find("</svg>", begin);
    const std::string svg = html.substr(begin, end - begin);
    const std::regex label("text-anchor='end'>([^<]*)</text>");
    std::vector<std::string> labels;
    for (auto at = std::sregex_iterator(svg.begin(), svg.end(), label); at != std::sregex_iterator(); ++at)
        if ((*at)[1] != "frame") labels.push_back((*at)[1]);
    return labels;
}

TEST_F(Report, AxesHaveDistinctLabelsAndCountsWholeOnes) {
    page({"--frames", "1-5"});
    const std::string html = contentsOf(folder_ / "web/page.html");
    for (const char* title : {"Particles and triangles", "Volume", "Components", "Peak memory of the process",
                              "Retries and warnings", "Time by stage, from a millisecond"}) {
        const std::vector<std::string> labels = labelsOf(html, title);
        EXPECT_GE(labels.size(), 2U) << title;
        EXPECT_LE(labels.size(), 11U) << title;
        EXPECT_EQ(std::set<std::string>(labels.begin(), labels.end()).size(), labels.size()) << title;
    }
    for (const char* title : {"Particles and triangles", "Components", "Retries and warnings"})
        for (const std::string& label : labelsOf(html, title))
            EXPECT_EQ(label.find('.'), std::string::npos) << title << ' ' << label;
    EXPECT_EQ(count(html, ">2.5</text>"), 0U);  // frames are whole numbers
}

TEST_F(Report, APreviewOpensLargeByItsLink) {
    page();
    const std::string html = contentsOf(folder_ / "web/page.html");
    EXPECT_EQ(count(html, "<figure id=\"previews-1-frame-2\"><a href=\"#previews-1-frame-2\"><img "), 1U);
    EXPECT_EQ(count(html, "<a href=\"#previews-1\">close</a>"), 1U);
    EXPECT_EQ(count(html, "figure:target{position:fixed"), 1U);
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
    const std::string url = "file://" + folder_ / "web/page.html";
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
