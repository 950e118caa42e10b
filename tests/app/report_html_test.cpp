// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/report_html.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/files.h"
#include "app/picture.h"
#include "app/report_svg.h"
#include "codec/codec.h"
#include "codec/decode.h"
#include "json_schema.h"
#include "run_command.h"
#include "wavelet/wavelet.h"

namespace nacre::app {
namespace {

std::span<const std::uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++count;
  return count;
}

/// A run of profile paper on a bumpy sphere, all of it real but the times.
struct Example {
  Scan scan = shapes::bumpy_sphere(4);
  SemiRegularMesh mesh;
  std::vector<std::uint8_t> stream;
  EncodeRun run;
  HtmlExtras extras;

  Example() {
    const Scan base = shapes::icosahedron();
    mesh = {base.triangles, 12, 3, base.positions, Vec3::Zero()};
    const Topology topology = *Topology::build(mesh.base_triangles, 12, 3);
    for (int j = 0; j < 3; ++j) {
      for (const Vec3& p : wavelet::predict(topology, j, mesh.positions).points)
        mesh.positions.push_back(p / p.norm() * (1 + 0.05 * std::sin(5 * p[0])));
    }
    codec::EncodeOptions options;
    options.target_bytes = 600;
    codec::Encoded encoded = codec::encode(mesh, options).value();
    stream = encoded.bytes;
    run.coded = encoded.report;
    run.coded.bytes = stream.size();
    run.command.scan = run.input.file = "dir/<b>&'\"scan.ply";
    run.command.profile = codec::Profile::kPaper;
    run.command.samples = 2000;
    run.input.faces = scan.triangles.size();
    run.input.goal_vertices = run.input.vertices = scan.positions.size();
    run.input.read.not_carried = {"red", "green"};
    run.levels = level_facts(codec::inspect(stream).value());
    run.levels[0].psnr_db = 31.5;
    run.levels[0].max_error = 0.25;
    run.distance = metric::compare(scan, to_triangles(codec::decode(stream).value()).value(),
                                   {.samples = 2000})
                       .value();
    run.costs = {{"read", 0.25, 1000}, {"remesh", 2, 5000}, {"encode", 1, 4000}};
    run.seconds = 3.5;
    const std::atomic<bool> cancel = false;
    Console console(Verbosity::kQuiet, cancel);
    extras = html_extras(run, scan, mesh, stream, console).value();
  }
};

const Example& example() {
  static const Example made;
  return made;
}

TEST(Base64, GivesTheTestVectorsOfItsStandard) {
  const char* vectors[][2] = {{"", ""},
                              {"f", "Zg=="},
                              {"fo", "Zm8="},
                              {"foo", "Zm9v"},
                              {"foob", "Zm9vYg=="},
                              {"fooba", "Zm9vYmE="},
                              {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : vectors) EXPECT_EQ(base64(as_bytes(plain)), coded);
  const std::vector<std::uint8_t> high = {0xFB, 0xFF, 0xBF};
  EXPECT_EQ(base64(high), "+/+/");
}

TEST(Escaped, LeavesNothingThatHtmlWouldRead) {
  EXPECT_EQ(escaped("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(escaped("gr\xC3\xBC\xC3\x9F"), "gr\xC3\xBC\xC3\x9F");
  EXPECT_EQ(escaped("a\nb"), "a b");
  const std::string broken = escaped("x\xC3(\x01\xFF");
  EXPECT_EQ(broken, "x\xEF\xBF\xBD(\xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(Ticks, AreRoundNumbersInside) {
  EXPECT_EQ(ticks(0, 10, 5, false), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(ticks(31, 58, 5, false), (std::vector<double>{35, 40, 45, 50, 55}));
  const std::vector<double> sizes = ticks(300, 20'000, 6, true);
  EXPECT_EQ(sizes, (std::vector<double>{500, 1000, 2000, 5000, 10'000, 20'000}));
  EXPECT_LE(ticks(1e-12, 1e3, 5, true).size(), 10u);
  EXPECT_TRUE(ticks(1, 1, 5, false).empty());
  EXPECT_TRUE(ticks(-1, 1, 5, true).empty());
  EXPECT_TRUE(ticks(0, std::numeric_limits<double>::infinity(), 5, false).empty());
}

TEST(Svg, LeavesOutWhatCannotBeDrawn) {
  Plot plot;
  plot.title = "t<t>";
  plot.x.logarithmic = true;
  const double inf = std::numeric_limits<double>::infinity();
  plot.series.push_back(
      {{{1, 2}, {10, 3}, {0, 5}, {-1, 5}, {100, inf}, {100, 1}}, true, true, "c1", ""});
  const std::string drawn = svg(plot);
  EXPECT_EQ(count_of(drawn, "<circle"), 3u);
  EXPECT_EQ(drawn.find("nan"), std::string::npos);
  EXPECT_EQ(drawn.find("inf"), std::string::npos);
  EXPECT_NE(drawn.find("t&lt;t&gt;"), std::string::npos);
  plot.series[0].points = {{0, 1}};
  EXPECT_EQ(svg(plot).find("<svg"), std::string::npos);
  plot.series[0].points = {{5, 1}};  // one point alone has a place, too
  EXPECT_EQ(svg(plot).find("nan"), std::string::npos);
}

TEST(HtmlReport, HasItsPicturesPlotsAndTables) {
  const std::string page = to_html(example().run, example().extras);
  EXPECT_EQ(count_of(page, "<img "), 4u);
  EXPECT_EQ(count_of(page, "data:image/png;base64,iVBOR"), 4u);
  // Rate and distortion, histogram, and a curve for each band that was sampled.
  std::size_t sampled = 0;
  for (const codec::BandReport& band : example().run.coded.bands) sampled += !band.samples.empty();
  EXPECT_GE(sampled, 2u);
  EXPECT_EQ(count_of(page, "<svg "), 2 + sampled);
  for (const char* heading : {"Pictures", "Rate and distortion", "Levels", "Distances",
                              "Bytes by part", "Bands", "Time and memory"})
    EXPECT_NE(page.find(std::string("<h2>") + heading), std::string::npos) << heading;
  EXPECT_EQ(count_of(page, ">smoothing spline<") + count_of(page, ">convex hull<"), sampled);
  EXPECT_NE(page.find("not carried: red, green"), std::string::npos);
  EXPECT_GE(example().extras.rd_curve.size(), 2u);
}

TEST(HtmlReport, LoadsNothingAndRunsNothing) {
  const std::string page = to_html(example().run, example().extras);
  for (const char* no : {"http:", "https:", "<script", "@import", "url(", "file:", "javascript:"})
    EXPECT_EQ(page.find(no), std::string::npos) << no;
  EXPECT_NE(page.find("&lt;b&gt;&amp;&#39;&quot;scan.ply"), std::string::npos);
  EXPECT_EQ(page.find("<b>&'"), std::string::npos);
  EXPECT_NE(page.find("prefers-color-scheme:dark"), std::string::npos);
  EXPECT_NE(page.find("@media print"), std::string::npos);
}

TEST(HtmlReport, IsTheSameEachTime) {
  EXPECT_EQ(to_html(example().run, example().extras), to_html(example().run, example().extras));
}

TEST(HtmlReport, StandsWithoutMeasurementsAndExtras) {
  EncodeRun run;
  run.input.file = "x.ply";
  const std::string page = to_html(run, {});
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_EQ(count_of(page, "<img "), 0u);
}

/// The page with a script at its end that writes what it finds into the page.
std::string with_probe(std::string page) {
  const std::string probe =
      "<p id=\"probe\">waiting</p><script>\n"
      "window.addEventListener('load', () => {\n"
      "  const images = [...document.images];\n"
      "  const decoded = images.filter(i => i.complete && i.naturalWidth > 0).length;\n"
      "  const plots = [...document.querySelectorAll('svg')];\n"
      "  const drawn = plots.filter(s => s.getBBox().width > 100).length;\n"
      "  const loaded = performance.getEntriesByType('resource')\n"
      "    .filter(r => !r.name.startsWith('data:')).length;\n"
      "  document.getElementById('probe').textContent = `images ${decoded}/${images.length} "
      "plots ${drawn}/${plots.length} loaded ${loaded}`;\n"
      "});</script>";
  return page.replace(page.find("</body>"), 7, probe + "</body>");
}

// Headless, without network. The console's messages come on stderr.
TEST(HtmlReport, OpensInChromiumWithItsPicturesAndWithoutAnError) {
  if (std::system("command -v chromium >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "chromium is not installed: the page was not opened in a browser";
  const test::Scratch scratch;
  const std::string page = to_html(example().run, example().extras);
  scratch.write("report.html", with_probe(page));
  const std::string command =
      "timeout 120 chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
      "--host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr --v=0 "
      "--user-data-dir=" +
      scratch.file("profile").string() + " --dump-dom file://" +
      scratch.file("report.html").string() + " >" + scratch.file("dom").string() + " 2>" +
      scratch.file("log").string();
  ASSERT_EQ(std::system(command.c_str()), 0) << scratch.read("log");
  const std::string dom = scratch.read("dom"), log = scratch.read("log");
  const std::size_t plots = count_of(page, "<svg ");
  EXPECT_NE(dom.find("images 4/4 plots " + std::to_string(plots) + "/" + std::to_string(plots) +
                     " loaded 0"),
            std::string::npos)
      << dom.substr(dom.find("id=\"probe\""));
  EXPECT_EQ(log.find(":CONSOLE"), std::string::npos) << log;
}

test::SchemaChecker schema() {
  std::ifstream file(NACRE_SOURCE_DIR "/docs/report.schema.json");
  return test::SchemaChecker(nlohmann::json::parse(file));
}

TEST(ReportSchema, IsMetByAReport) {
  const auto report = nlohmann::json::parse(to_json(example().run));
  EXPECT_EQ(schema().problems(report), std::vector<std::string>());
  EXPECT_EQ(report["schema_version"], 1);
}

TEST(ReportSchema, DescribesEveryMember) {
  EncodeRun run = example().run;
  run.from = Reentry{"05-normal-mesh", "w/05-normal-mesh", {"positions.npy"}};
  run.remesh.clean.actions = {{"welded vertices", 2, {0, 1}, 0.5, 0.25}};
  run.remesh.pieces.emplace_back();
  run.remesh.bands.emplace_back();
  run.remesh_distance = run.distance;
  run.certified = metric::certified_distance(example().scan, shapes::sphere(2)).value();
  RemeshRun remesh;
  remesh.input = run.input;
  remesh.remesh = run.remesh;
  remesh.distance = run.distance;
  remesh.costs = run.costs;
  remesh.from = run.from;
  for (const std::string& text : {to_json(run), to_json(remesh)}) {
    const auto report = nlohmann::json::parse(text);
    EXPECT_EQ(schema().problems(report), std::vector<std::string>());
    EXPECT_EQ(schema().undescribed(report), std::vector<std::string>());
  }
}

TEST(ReportSchema, IsMetByAComparisonWithAndWithoutACertificate) {
  const Scan a = shapes::sphere(2), b = shapes::icosahedron();
  const metric::Comparison c = metric::compare(a, b, {.samples = 2000}).value();
  const metric::Certified certified = metric::certified_distance(a, b).value();
  for (const std::string& text : {to_json(c), to_json(c, certified)})
    EXPECT_EQ(schema().problems(nlohmann::json::parse(text), "distance"),
              std::vector<std::string>());
  const metric::Comparison same = metric::compare(a, a, {.samples = 2000}).value();
  EXPECT_EQ(schema().problems(nlohmann::json::parse(to_json(same)), "distance"),
            std::vector<std::string>());
}

TEST(ReportSchema, FindsWhatIsWrong) {
  const auto good = nlohmann::json::parse(to_json(example().run));
  const auto broken = [&](const auto& change) {
    auto report = good;
    change(report);
    return !schema().problems(report).empty();
  };
  EXPECT_TRUE(broken([](auto& r) { r.erase("bytes"); }));
  EXPECT_TRUE(broken([](auto& r) { r["bytes"] = "600"; }));
  EXPECT_TRUE(broken([](auto& r) { r["schema_version"] = 2; }));
  EXPECT_TRUE(broken([](auto& r) { r["bands"][0]["vertices"] = -1; }));
  EXPECT_TRUE(broken([](auto& r) { r["distance"]["max"]["on"] = "C"; }));
  EXPECT_TRUE(broken([](auto& r) { r["seconds"]["read"] = nullptr; }));
  EXPECT_FALSE(broken([](auto& r) { r["new_field"] = 1; }));
  auto more = good;
  more["bands"][0]["new_field"] = 1;
  EXPECT_EQ(schema().undescribed(more), std::vector<std::string>{"/bands/0/new_field"});
}

}  // namespace
}  // namespace nacre::app
