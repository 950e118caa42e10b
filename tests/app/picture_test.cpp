// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/picture.h"

#include <gtest/gtest.h>
#include <png.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "support/shapes.h"

namespace nacre::app {
namespace {

using Pixel = std::array<int, 3>;

Pixel at(const Image& image, int x, int y) {
  const std::size_t i = (static_cast<std::size_t>(y) * image.width + x) * 3;
  return {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]};
}

PictureOptions front(int size = 96) {
  PictureOptions options;
  options.panel_width = options.panel_height = size;
  options.view = {.up = View::Up::kY, .azimuth_deg = 0, .elevation_deg = 0};
  return options;
}

Image draw(const Panel& panel, const PictureOptions& options) {
  auto image = render({&panel, 1}, options);
  EXPECT_TRUE(image.has_value()) << image.error().message;
  return *image;
}

Panel panel_of(const Scan& scan) {
  Panel panel;
  panel.mesh = &scan;
  return panel;
}

Scan square(double z = 0) {
  return {{{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}}, {{0, 1, 2}, {0, 2, 3}}};
}

bool is_background(const Pixel& p) { return p[2] >= p[0] && p[0] > 200; }  // clay is warmer
bool is_back_face(const Pixel& p) { return p[0] > 2 * p[1]; }

TEST(Render, ASquareFillsThePanelUpToItsMargin) {
  const Scan scan = square();
  const Image image = draw(panel_of(scan), front(100));
  EXPECT_EQ(image.width, 100);
  EXPECT_EQ(image.height, 100);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      const bool inside = x >= 6 && x < 94 && y >= 6 && y < 94;
      ASSERT_EQ(is_background(at(image, x, y)), !inside) << x << ' ' << y;
    }
  }
}

TEST(Render, BackFacesHaveATintOfTheirOwn) {
  const Scan scan = square();
  Scan turned = scan;
  for (Triangle& t : turned.triangles) std::swap(t[1], t[2]);
  EXPECT_FALSE(is_back_face(at(draw(panel_of(scan), front()), 48, 48)));
  EXPECT_TRUE(is_back_face(at(draw(panel_of(turned), front()), 48, 48)));
}

TEST(Render, ThroughAHoleOneSeesTheFarSidesBack) {
  Scan ball = shapes::sphere(4);
  std::erase_if(ball.triangles, [&](const Triangle& t) {
    return ball.positions[t[0]][2] > 0.9;  // open toward the viewer
  });
  const Image image = draw(panel_of(ball), front());
  EXPECT_TRUE(is_back_face(at(image, 48, 48)));
  EXPECT_FALSE(is_back_face(at(image, 48, 20)));
}

TEST(Render, ColoursOfFacesWinOverThoseOfVertices) {
  using Rgb = std::array<std::uint8_t, 3>;
  const Scan scan = square();
  const std::vector<Rgb> vertex(4, Rgb{20, 200, 20});
  const std::vector<Rgb> face = {{200, 20, 20}, {20, 20, 200}};  // below and above the diagonal
  Panel panel = panel_of(scan);
  panel.vertex_color = vertex;
  const Pixel green = at(draw(panel, front()), 48, 60);
  EXPECT_GT(green[1], 2 * std::max(green[0], green[2]));
  panel.face_color = face;
  const Image image = draw(panel, front());
  EXPECT_GT(at(image, 60, 80)[0], 2 * at(image, 60, 80)[2]);
  EXPECT_GT(at(image, 30, 20)[2], 2 * at(image, 30, 20)[0]);
  panel.face_color = std::span(face).first(1);
  EXPECT_EQ(render({&panel, 1}, front()).error().code, ErrorCode::kBadInput);
}

TEST(Render, TheNearerSurfaceWinsInAnyOrder) {
  Scan two = square(0);
  const Scan far = square(-1);  // behind, turned away
  for (const Triangle& t : far.triangles) two.triangles.push_back({t[0] + 4, t[2] + 4, t[1] + 4});
  two.positions.insert(two.positions.end(), far.positions.begin(), far.positions.end());
  const Image image = draw(panel_of(two), front());
  EXPECT_FALSE(is_back_face(at(image, 48, 48)));
  Scan reversed = two;
  std::reverse(reversed.triangles.begin(), reversed.triangles.end());
  EXPECT_EQ(draw(panel_of(reversed), front()).rgb, image.rgb);
  PictureOptions behind = front();
  behind.view.azimuth_deg = 180;
  EXPECT_FALSE(is_back_face(at(draw(panel_of(two), behind), 48, 48)));
}

TEST(Render, UpAxesAreTurnsOfEachOther) {
  // The same object, its coordinates turned with the up axis, gives the same picture.
  const Scan original = shapes::torus(24, 12);
  PictureOptions options = front();
  options.view.azimuth_deg = 33;
  options.view.elevation_deg = 21;
  const Image expected = draw(panel_of(original), options);
  Scan turned = original;
  for (Vec3& p : turned.positions) p = Vec3(p[2], p[0], p[1]);
  options.view.up = View::Up::kZ;
  const Image seen = draw(panel_of(turned), options);
  std::size_t different = 0;
  for (std::size_t i = 0; i < seen.rgb.size(); ++i)
    different += std::abs(int{seen.rgb[i]} - int{expected.rgb[i]}) > 3;
  EXPECT_LT(different, seen.rgb.size() / 500);  // rounding on silhouettes only
}

TEST(Render, QualityRunsFromTheFirstToTheLastColour) {
  const Scan scan = square();
  const std::vector<float> none(4, 0.0F), full(4, 2.0F);
  Panel panel = panel_of(scan);
  PictureOptions options = front();
  options.quality_max = 2;
  panel.quality = none;
  const Pixel low = at(draw(panel, options), 48, 30);
  panel.quality = full;
  const Pixel high = at(draw(panel, options), 48, 30);
  EXPECT_GT(low[2], low[1]);        // purple
  EXPECT_GT(high[0], 2 * high[2]);  // yellow
  EXPECT_GT(high[1], 2 * high[2]);
}

TEST(Render, AFewOutliersDoNotDarkenTheRest) {
  const Scan scan = shapes::grid(40, 40);
  std::vector<float> quality(scan.positions.size(), 1.0F);
  quality[5] = 1e6F;
  Panel panel = panel_of(scan);
  panel.quality = quality;
  const Pixel p = at(draw(panel, front()), 48, 40);
  EXPECT_GT(p[0], 2 * p[2]);  // 1.0 is the end of the scale
}

TEST(Render, TheWireIsDrawnOverTheSurfaceButNotThroughIt) {
  const Scan scan = square();
  Scan wire = square(-0.02);  // a chord just below the surface still shows
  Panel panel = panel_of(scan);
  const auto darkness = [&](const Image& image) {
    const Pixel p = at(image, 48, 47);  // on the diagonal
    return 3 * 255 - p[0] - p[1] - p[2];
  };
  const int bare = darkness(draw(panel, front()));
  panel.wire = &wire;
  EXPECT_GT(darkness(draw(panel, front())), bare + 150);
  wire = square(-1.5);
  EXPECT_EQ(darkness(draw(panel, front())), bare);
}

TEST(Render, PanelsShareTheCamera) {
  const Scan large = square();
  Scan small = large;
  for (Vec3& p : small.positions) p *= 0.5;
  const std::array<Panel, 2> panels = {panel_of(large), panel_of(small)};
  const auto image = render(panels, front(100));
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(image->width, 200);
  EXPECT_FALSE(is_background(at(*image, 10, 50)));
  EXPECT_TRUE(is_background(at(*image, 110, 50)));
  EXPECT_FALSE(is_background(at(*image, 135, 50)));
}

TEST(Render, OriginsAreTakenIntoAccount) {
  const Scan at_zero = square();
  Scan far = at_zero;
  far.origin = Vec3(500'000, 5'000'000, 300);
  Scan near_it = at_zero;
  near_it.origin = far.origin + Vec3(1, 0, 0);
  for (Vec3& p : near_it.positions) p -= Vec3(1, 0, 0);
  const std::array<Panel, 2> panels = {panel_of(far), panel_of(near_it)};
  const auto image = render(panels, front(100));
  ASSERT_TRUE(image.has_value());
  for (int x = 0; x < 100; ++x)
    EXPECT_EQ(is_background(at(*image, x, 50)), is_background(at(*image, 100 + x, 50)));
}

TEST(Render, CaptionsMakeRoomForThemselves) {
  const Scan scan = square();
  Panel panel = panel_of(scan);
  panel.caption = "one line";
  const Image one = draw(panel, front(100));
  panel.caption = "two\nlines, one of which is longer than the panel is wide, so it is cut";
  const Image two = draw(panel, front(100));
  EXPECT_GT(one.height, 100);
  EXPECT_GT(two.height, one.height);
  bool ink = false;
  for (int y = 100; y < one.height; ++y)
    for (int x = 0; x < 100; ++x) ink = ink || at(one, x, y)[0] < 100;
  EXPECT_TRUE(ink);
}

TEST(Render, IsTheSameBytesAtAnyThreadCount) {
  const Scan scan = shapes::torus(60, 30);
  std::vector<float> quality;
  for (const Vec3& p : scan.positions) quality.push_back(static_cast<float>(p[0] + 1));
  Panel panel = panel_of(scan);
  panel.quality = quality;
  panel.wire = &scan;
  panel.caption = "torus";
  const auto many = render_png({&panel, 1});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(*render_png({&panel, 1}), *many);
}

TEST(Render, SurvivesOddMeshes) {
  const Scan empty, lone{{{0, 0, 0}}, {}};
  const Scan flat{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}}};
  const double nan = std::numeric_limits<double>::quiet_NaN(), huge = 1e300;
  const Scan broken{{{nan, 0, 0}, {1, nan, 0}, {0, 1, huge}, {huge, huge, 0}},
                    {{0, 1, 2}, {1, 2, 3}}};
  const std::array<Panel, 5> panels = {Panel{}, panel_of(empty), panel_of(lone), panel_of(flat),
                                       panel_of(broken)};
  EXPECT_TRUE(render(panels, front()).has_value());
  Panel wired = panel_of(broken);
  wired.wire = &broken;
  EXPECT_TRUE(render({&wired, 1}, front()).has_value());
  const Scan good = square();
  Panel mixed = panel_of(good);
  const std::vector<float> quality = {std::nanf(""), 1, std::numeric_limits<float>::infinity(), -1};
  mixed.quality = quality;
  mixed.wire = &broken;
  EXPECT_TRUE(render({&mixed, 1}, front()).has_value());
}

TEST(Render, RefusesWhatItCannotDraw) {
  const Scan scan = square();
  const Scan dangling{{{0, 0, 0}}, {{0, 0, 7}}};
  const std::vector<float> short_quality(3, 0.0F);
  const auto code = [](const Panel& panel, const PictureOptions& options) {
    const auto image = render({&panel, 1}, options);
    EXPECT_FALSE(image.has_value());
    return image.has_value() ? ErrorCode::kCancelled : image.error().code;
  };
  EXPECT_EQ(render({}, front()).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(code(panel_of(dangling), front()), ErrorCode::kBadInput);
  Panel wrong = panel_of(scan);
  wrong.quality = short_quality;
  EXPECT_EQ(code(wrong, front()), ErrorCode::kBadInput);
  EXPECT_EQ(code(panel_of(scan), front(63)), ErrorCode::kBadInput);
  PictureOptions options = front();
  options.view.elevation_deg = std::nan("");
  EXPECT_EQ(code(panel_of(scan), options), ErrorCode::kBadInput);
  options = front(8192);
  options.supersampling = 4;
  EXPECT_EQ(code(panel_of(scan), options), ErrorCode::kLimitExceeded);
}

TEST(EncodePng, DecodesToTheSamePixels) {
  const Scan scan = shapes::torus(20, 10);
  const Image image = draw(panel_of(scan), front());
  const auto bytes = encode_png(image);
  ASSERT_TRUE(bytes.has_value());
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&header, bytes->data(), bytes->size()), 0);
  ASSERT_EQ(static_cast<int>(header.width), image.width);
  ASSERT_EQ(static_cast<int>(header.height), image.height);
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(header));
  ASSERT_NE(png_image_finish_read(&header, nullptr, rgb.data(), 0, nullptr), 0);
  EXPECT_EQ(rgb, image.rgb);
}

TEST(EncodePng, RefusesAnImageOfTheWrongSize) {
  EXPECT_EQ(encode_png({.width = 2, .height = 2, .rgb = {1, 2, 3}}).error().code,
            ErrorCode::kBadInput);
  EXPECT_FALSE(encode_png({}).has_value());
}

TEST(Viridis, EndsAndMonotoneLightness) {
  EXPECT_EQ(viridis(0), (std::array<std::uint8_t, 3>{68, 1, 84}));
  EXPECT_EQ(viridis(1), (std::array<std::uint8_t, 3>{253, 231, 37}));
  EXPECT_EQ(viridis(-3), viridis(0));
  EXPECT_EQ(viridis(7), viridis(1));
  double before = -1;
  for (int i = 0; i <= 100; ++i) {
    const auto c = viridis(i / 100.0);
    const double lightness = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    EXPECT_GT(lightness, before);
    before = lightness;
  }
}

}  // namespace
}  // namespace nacre::app
