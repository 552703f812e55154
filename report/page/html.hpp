#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

// Pieces of HTML. Set-up.
namespace stillframe::page {

/// Text as it may stand in an element or between the quotes of an attribute: markup is escaped,
/// bytes that are not UTF-8 and control characters become the replacement character.
std::string escape(std::string_view text);

using Attributes = std::initializer_list<std::pair<std::string_view, std::string_view>>;

/// <name attributes>content</name>; attribute values are escaped, content is HTML already.
std::string element(std::string_view name, Attributes attributes, std::string_view content);

/// The same around text, which is escaped.
std::string text_element(std::string_view name, Attributes attributes, std::string_view text);

/// A number with so many significant digits, without a power of ten between 0.001 and 1e6; a
/// dash if it is not finite. Minus signs are typographic.
std::string number_text(double value, int digits = 3);

/// A number as short as six digits allow: 1000, 12.5.
std::string short_number(double value);

}  // namespace stillframe::page
