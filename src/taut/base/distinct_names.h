#pragma once
/// Names that differ from one another.

#include <string>
#include <unordered_map>
#include <unordered_set>

namespace taut {

class DistinctNames {
  public:
    /// `name`, or name_2, name_3 ... where it is taken. `key` brings names that count as one to one form; `longest`: of a result, in
    /// bytes; `shorten(name, bytes)` cuts a name. In time that grows with the number of names alone, however many are alike.
    template <class Key, class Shorten>
    std::string add(const std::string &name, std::size_t longest, const Key &key, const Shorten &shorten) {
        const std::string base = shorten(name, longest);
        std::string candidate = base;
        for (unsigned long &next = next_[key(base)]; !taken_.insert(key(candidate)).second;) {
            const std::string suffix = std::string(1, '_') + std::to_string(next++ + 2);
            candidate = shorten(base, longest - suffix.size()) + suffix;
        }
        return candidate;
    }
    std::string add(const std::string &name) {
        const auto same = [](const std::string &text) { return text; };
        return add(name, std::string::npos, same, [](const std::string &text, std::size_t /*bytes*/) { return text; });
    }

  private:
    std::unordered_set<std::string> taken_;
    std::unordered_map<std::string, unsigned long> next_; ///< suffixes used of each name
};

} // namespace taut
