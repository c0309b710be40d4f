// FarHosts makes other computers for a test: network namespaces with an sshd each, behind lines that delay,
// lose and can be cut (tests/support/far_hosts.py).
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace firn::test {

class FarHosts {
 public:
  /// Why this machine gives no such computers; empty: it does.
  static std::string refused();

  explicit FarHosts(const std::vector<std::string>& names);
  ~FarHosts();
  FarHosts(const FarHosts&) = delete;
  FarHosts& operator=(const FarHosts&) = delete;

  /// The line takes `delay_s` +- `jitter_s` one way and loses the share `loss` of its packets.
  void line(const std::string& host, double delay_s, double jitter_s, double loss);
  void cut(const std::string& host) { order("cut " + host); }
  void mend(const std::string& host) { order("mend " + host); }
  void freeze(const std::string& host) { order("freeze " + host); }
  void thaw(const std::string& host) { order("thaw " + host); }
  /// Processes there, without sshd.
  std::vector<int> pids(const std::string& host);
  /// Returns a program that is firn with these variables set: "LD_PRELOAD=x.so A=b". Its processes have them
  /// too. @param days by which its monotonic clocks are ahead: a time namespace
  std::string firn_with(const std::string& variables, int days = 0) const;
  /// Returns a program that is firn on a computer which was booted apart from this one.
  std::string firn_elsewhere() const;
  /// Folder of the hosts' records: FOLDER/HOST/firn/hosts; of installed builds: FOLDER/HOST/data.
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::string order(const std::string& line);
  std::string answer();

  std::filesystem::path folder_;
  int pid_ = -1;
  std::FILE* to_ = nullptr;
  std::FILE* from_ = nullptr;
  std::string path_before_;
};

}  // namespace firn::test
