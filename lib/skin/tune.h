#pragma once
#include <cstdlib>
#include <cstring>
#include <string>
namespace betamesh {
// development only: "name=value,name=value" in BM_TUNE
inline double tune(const char* name, double value) {
    const char* all = std::getenv("BM_TUNE");
    if (!all) return value;
    const std::string s = std::string(",") + all, key = std::string(",") + name + "=";
    const auto at = s.find(key);
    return at == std::string::npos ? value : std::atof(s.c_str() + at + key.size());
}
}  // namespace betamesh
