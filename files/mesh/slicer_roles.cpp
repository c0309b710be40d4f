#include "files/mesh/slicer_roles.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/options/number.h"
#include "files/lowercase.h"
#include "files/mesh/xml_reader.h"

namespace firn::mesh {
namespace {

class RolesHandler final : public XmlHandler {
 public:
  RolesHandler(const std::string& source, SlicerRoles& roles) : reader_(source, *this), roles_(roles) {}
  XmlReader& reader() { return reader_; }

  void begin(const XmlName& element, const XmlAttributes& a) override {
    if (element.local == "object") {
      object_ = std::string(a.find("id").value_or(""));
    } else if (element.local == "plate") {
      ++roles_.plates;
    } else if (element.local == "volume" || element.local == "part") {
      volume_.emplace();
      volume_->role = a.find("subtype").value_or("");
      component_ = std::string(a.find("id").value_or(""));
      by_triangles_ = a.find("firstid") && a.find("lastid");
      if (by_triangles_) {
        volume_->first = number(*a.find("firstid"));
        volume_->behind = number(*a.find("lastid")) + 1;
      }
    } else if (element.local == "metadata" && volume_) {
      const std::string_view key = a.find("key").value_or(""), value = a.find("value").value_or("");
      if (key == "name") volume_->name = value;
      if (key == "volume_type" || key == "subtype") volume_->role = value;
      if (key == "modifier" && value == "1" && volume_->role.empty()) volume_->role = "modifier";
    }
  }

  void end(const XmlName& element) override {
    if ((element.local != "volume" && element.local != "part") || !volume_) return;
    SlicerRoles::OfObject& object = roles_.objects[object_];
    if (by_triangles_)
      object.volumes.push_back(std::move(*volume_));
    else
      object.components.insert_or_assign(component_, std::move(*volume_));
    volume_.reset();
  }

 private:
  std::size_t number(std::string_view text) const {
    const std::optional<std::uint32_t> value = whole_number<std::uint32_t>(text);
    if (!value) reader_.fail(fmt::format("\"{}\" is not the number of a triangle", text.substr(0, 40)));
    return *value;
  }

  XmlReader reader_;
  SlicerRoles& roles_;
  std::string object_, component_;
  bool by_triangles_ = false;
  std::optional<Volume3mf> volume_;
};

}  // namespace

SlicerRoles read_slicer_roles(ZipPackage& package) {
  SlicerRoles roles;
  for (const std::string& part : package.parts()) {
    const std::string name = lowercase(part);
    if (!name.starts_with("metadata/") ||
        (!name.ends_with("model.config") && !name.ends_with("model_settings.config")))
      continue;
    RolesHandler handler(package.name() + ": " + part, roles);
    package.read(part, [&](std::string_view piece) { handler.reader().read(piece); });
    handler.reader().finish();
  }
  return roles;
}

VolumeUse use_of_role(const std::string& role) {
  std::string word = lowercase(role);
  std::erase(word, '_');
  const auto is_one_of = [&](std::initializer_list<std::string_view> words) {
    return std::ranges::find(words, word) != words.end();
  };
  if (is_one_of({"", "modelpart", "normalpart"})) return VolumeUse::kPrinted;
  if (is_one_of({"parametermodifier", "modifier", "modifierpart", "supportenforcer", "supportblocker",
                 "supportmesh", "antioverhangmesh", "infillmesh", "cuttingmesh"}))
    return VolumeUse::kLeftOut;
  return VolumeUse::kRefused;
}

}  // namespace firn::mesh
