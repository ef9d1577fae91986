// The figures of each chapter; figures.cpp joins them.
#pragma once

#include "omniflight_reproduction/figure.hpp"

namespace omniflight::reproduction {

std::vector<Figure> chapter_4();
std::vector<Figure> chapter_5();
std::vector<Figure> chapter_6();
std::vector<Figure> chapter_7();
std::vector<Figure> appendix();

}  // namespace omniflight::reproduction
