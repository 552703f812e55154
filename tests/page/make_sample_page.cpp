// Writes the pages that tests/browser opens: make_sample_page KIND PATH
// [SECONDS], KIND sample, hostile or empty.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "report/page/write_page.hpp"
#include "tests/page/sample_page.hpp"

int main(int count, char** arguments) {
  const std::string kind = count == 3 || count == 4 ? arguments[1] : "";
  const double duration_s = count == 4 ? std::atof(arguments[3]) : 60;
  if (kind == "sample") {
    stillframe::page::write_page(stillframe::test::sample_page(duration_s), arguments[2]);
  } else if (kind == "hostile") {
    stillframe::page::write_page(stillframe::test::hostile_page(), arguments[2]);
  } else if (kind == "empty") {
    stillframe::page::write_page({}, arguments[2]);
  } else {
    std::fputs("usage: make_sample_page sample|hostile|empty PATH [SECONDS]\n", stderr);
    return 2;
  }
  return 0;
}
