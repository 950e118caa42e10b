// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/progress.h"
#include "app/report.h"
#include "base/semi_regular_mesh.h"

/// What an encode did, as one page: pictures, plots and tables, nothing loaded from elsewhere.
namespace nacre::app {

/// What the page shows and EncodeRun does not have.
struct HtmlExtras {
  struct Picture {
    std::string caption;
    std::vector<std::uint8_t> png;
  };
  struct RdPoint {
    std::size_t bytes = 0;
    double psnr_db = 0;
  };
  std::vector<Picture> pictures;
  std::vector<RdPoint> rd_curve;  ///< the same mesh coded to other sizes, by rising size
};

/// Draws the scan, the base mesh, the decoded surface and the error on the scan from one side, and
/// codes the mesh to a few other sizes for the curve, which takes about as long as the encode's
/// own coding and measuring. `stream` is the file; `mesh`, the one it was coded from, may be empty:
/// no curve then.
///
/// Errors   kCancelled; those of metric::compare.
[[nodiscard]] Result<HtmlExtras> html_extras(const EncodeRun& run, const Scan& scan,
                                             const SemiRegularMesh& mesh,
                                             std::span<const std::uint8_t> stream,
                                             Console& console);

/// The page, UTF-8. Light or dark as the reader's system is; prints without backgrounds.
[[nodiscard]] std::string to_html(const EncodeRun& run, const HtmlExtras& extras);

/// RFC 4648, with padding.
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace nacre::app
