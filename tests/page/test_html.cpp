#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "report/page/html.hpp"
#include "report/page/json_text.hpp"
#include "tests/page/sample_page.hpp"

namespace stillframe::page {
namespace {

const std::string replacement = "\uFFFD";

TEST(Escape, MarkupBecomesText) {
  EXPECT_EQ(escape("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&#39;");
  EXPECT_EQ(escape("µm/s² – ok\n\tx"), "µm/s² – ok\n\tx");
}

/// Bytes that are no UTF-8 (RFC 3629): lone continuation, cut off, overlong, surrogate, too large.
TEST(Escape, WhatIsNotTextIsReplaced) {
  EXPECT_EQ(escape("a\x80z"), "a" + replacement + "z");
  EXPECT_EQ(escape("a\xE2\x82"), "a" + replacement + replacement);
  EXPECT_EQ(escape("\xC0\xBC"), replacement + replacement);  // an overlong '<'
  EXPECT_EQ(escape("\xE0\x80\xBC"), replacement + replacement + replacement);
  EXPECT_EQ(escape("\xED\xA0\x80"), replacement + replacement + replacement);
  EXPECT_EQ(escape("\xF4\x90\x80\x80"), replacement + replacement + replacement + replacement);
  EXPECT_EQ(escape("\xF0\x9F\x99\x82"), "\xF0\x9F\x99\x82");
  EXPECT_EQ(escape(std::string_view("a\0b\x1B", 4)), "a" + replacement + "b" + replacement);
}

TEST(Element, AttributesAreEscapedAndEmptyOnesLeftOut) {
  EXPECT_EQ(text_element("p", {{"title", "\"<x>"}, {"class", ""}}, "1 < 2"),
            "<p title=\"&quot;&lt;x&gt;\">1 &lt; 2</p>\n");
}

TEST(Number, SignificantDigitsWithoutExponent) {
  EXPECT_EQ(number_text(0.0041234), "0.00412");
  EXPECT_EQ(number_text(-22.8412), "\u221222.8");
  EXPECT_EQ(number_text(999.96), "1000");
  EXPECT_EQ(number_text(123456, 3), "123456");
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(number_text(1.5e-7, 2), "1.5\u00b710\u207b\u2077");
  EXPECT_EQ(number_text(-2.5e12, 2), "\u22122.5\u00b710\u00b9\u00b2");
  EXPECT_EQ(number_text(std::nan("")), "\u2013");
  EXPECT_EQ(number_text(HUGE_VAL), "\u2013");
  EXPECT_EQ(short_number(1000), "1000");
  EXPECT_EQ(short_number(-12.5), "\u221212.5");
}

TEST(JsonText, CannotEndItsElement) {
  const std::string text = script_safe(Json{{"name", test::hostile_name}});
  EXPECT_EQ(text.find_first_of("<>&"), std::string::npos) << text;
  EXPECT_EQ(Json::parse(text)["name"], test::hostile_name);
}

TEST(JsonText, IsAsciiAndTakesAnyBytes) {
  const std::string text = script_safe(Json{{"name", "\xff µ \u2028"}});
  for (const char c : text) EXPECT_LT(static_cast<unsigned char>(c), 0x80);
  EXPECT_EQ(Json::parse(text)["name"], replacement + " µ \u2028");
}

TEST(JsonText, NumbersKeepSixDigitsAndNonFiniteOnesAreNull) {
  EXPECT_EQ(rounded(M_PI).dump(), "3.14159");
  EXPECT_EQ(rounded(-1.23456789e-17).dump(), "-1.23457e-17");
  for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    EXPECT_TRUE(rounded(value).is_null());
  }
}

/// Test vectors of RFC 4648, section 10, in pairs of bytes: "fo", "foob", "foobar".
TEST(JsonText, Base64) {
  const auto pair = [](char low, char high) {
    return static_cast<std::int16_t>(low | static_cast<int>(high) << 8);
  };
  EXPECT_EQ(base64({}), "");
  EXPECT_EQ(base64({pair('f', 'o')}), "Zm8=");
  EXPECT_EQ(base64({pair('f', 'o'), pair('o', 'b')}), "Zm9vYg==");
  EXPECT_EQ(base64({pair('f', 'o'), pair('o', 'b'), pair('a', 'r')}), "Zm9vYmFy");
  EXPECT_EQ(base64({-1, 0}), "//8AAA==");
}

}  // namespace
}  // namespace stillframe::page
