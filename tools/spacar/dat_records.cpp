#include "tools/spacar/dat_records.hpp"

#include <algorithm>
#include <cmath>

#include "core/yaml/reader.hpp"
#include "core/yaml/to_number.hpp"
#include "tools/spacar/place.hpp"
#include "tools/spacar/source_text.hpp"

namespace stillframe::tools::spacar {

namespace {

std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  const std::string text = line.substr(0, line.find_first_of("#%!"));
  constexpr const char* gaps = " \t\f,";
  for (std::size_t begin = text.find_first_not_of(gaps); begin != std::string::npos;) {
    const std::size_t end = std::min(text.find_first_of(gaps, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(gaps, end);
  }
  return words;
}

std::string upper(const std::string& text) {
  std::string out = text;
  for (char& c : out) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return out;
}

}  // namespace

DatFile parse_dat(const std::vector<std::string>& lines, const std::string& name) {
  DatFile file{.name = name, .records = {}};
  int block = 0, n_ends = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int line = static_cast<int>(i) + 1;
    std::vector<std::string> words = words_of(lines[i]);
    if (words.empty()) continue;
    if (n_ends == 2) {
      file.first_line_of_pictures = line;
      return file;
    }
    const std::string keyword = upper(words.front());
    if ((keyword == "END" || keyword == "HALT") && words.size() > 1) {
      refuse(name, line, keyword, "'" + shown(words[1]) + "' behind it", "is nothing");
    }
    if (keyword == "END") {
      ++n_ends;
    } else if (keyword == "HALT" && n_ends == 1) {
      ++block;
      n_ends = 0;
    } else if (n_ends == 1 || keyword == "HALT") {
      refuse(name, line, shown(words.front()),
             n_ends == 1 ? "after one END" : "without an END before it",
             n_ends == 1 ? "are HALT, which another block follows, and END, which ends the file"
                         : "is HALT behind END");
    } else {
      words.erase(words.begin());
      file.records.push_back(
          {.line = line, .block = block, .keyword = keyword, .words = std::move(words)});
    }
  }
  if (n_ends != 2) {
    refuse(name, static_cast<int>(lines.size()), "END",
           "the end of the file after " + std::to_string(n_ends) + " END",
           "are two in a row, the last lines of the model");
  }
  return file;
}

int whole_number(const DatFile& file, const Record& record, std::size_t i) {
  const std::string& word = record.words.at(i);
  const auto value = to_number(word);
  if (!value || *value != std::floor(*value) || *value < 1 || *value > 1e8) {
    refuse(file.name, record.line, record.keyword, "'" + shown(word) + "'",
           "is a whole number from 1 up");
  }
  return static_cast<int>(*value);
}

double real_number(const DatFile& file, const Record& record, std::size_t i) {
  std::string word = record.words.at(i);
  const std::size_t exponent = word.find_first_of("dD");
  if (exponent != std::string::npos) word[exponent] = 'e';
  const auto value = to_number(word);
  if (!value || std::abs(*value) > largest_number) {
    refuse(file.name, record.line, record.keyword, "'" + shown(record.words[i]) + "'",
           "is a finite number, up to 1e30");
  }
  return *value;
}

std::vector<double> real_numbers(const DatFile& file, const Record& record, std::size_t from) {
  std::vector<double> numbers;
  for (std::size_t i = from; i < record.words.size(); ++i) {
    numbers.push_back(real_number(file, record, i));
  }
  return numbers;
}

void require_count(const DatFile& file, const Record& record, std::size_t least, std::size_t most,
                   const std::string& allowed) {
  if (record.words.size() >= least && record.words.size() <= most) return;
  refuse(file.name, record.line, record.keyword,
         std::to_string(record.words.size()) + (record.words.size() == 1 ? " number" : " numbers"),
         allowed);
}

}  // namespace stillframe::tools::spacar
