#include "tests/fuzz/seeds.hpp"

int main(int, char** arguments) { stillframe::fuzz::write_seeds(arguments[1]); }
