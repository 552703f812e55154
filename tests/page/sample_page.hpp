#pragma once

#include "report/page/page_data.hpp"

namespace stillframe::test {

/// A page in which every part is filled with plausible numbers: three axes and six legs, sampled at
/// 1 kHz for a time.
page::PageData sample_page(double duration_s = 60);

/// A page whose every text tries to break out of its element.
page::PageData hostile_page();

/// A name that would run a script or end an element if it were not escaped.
inline constexpr const char* hostile_name =
    "</script><script>window.broken=1</script><img src=x onerror=\"window.broken=1\">'\"&amp;<!--";

}  // namespace stillframe::test
