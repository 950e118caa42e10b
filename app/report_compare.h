// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "app/json.h"
#include "metric/metric.h"

/// Distances as JSON, for the reports that have them.
namespace nacre::app {

/// Keys as docs/report.schema.json has them; "certified" is null if there is none.
[[nodiscard]] Json comparison_json(const metric::Comparison& comparison,
                                   const std::optional<metric::Certified>& certified = {});

/// 100 distance / diagonal; 0 for no diagonal.
[[nodiscard]] double percent_of(double diagonal, double distance);

}  // namespace nacre::app
