// 3MF by lib3mf 1.8: every mesh of the build items, at its place. The library runs in a child process with
// bounds on time and memory: 1.5 kB of components within components keep it busy for ever, and a small
// archive may unpack to any size.
#include <fmt/core.h>
#include <lib3mf/Model/COM/NMR_DLLInterfaces.h>

#include <algorithm>
#include <memory>

#include "files/mesh/bounded_child.h"
#include "files/mesh/mesh_formats.h"
#include "files/mesh/mesh_message.h"
#include "files/mesh/package_3mf.h"
#include "files/usage_error.h"

namespace firn::mesh {
namespace {

using namespace NMR;

using Handle = PLib3MFBase*;
struct Release {
  void operator()(Handle p) const { lib3mf_release(p); }
};
using Owned = std::unique_ptr<PLib3MFBase, Release>;

using Affine = std::array<std::array<double, 4>, 3>;
constexpr Affine kIdentity{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

Affine from(const MODELTRANSFORM& t) {
  Affine a;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) a[std::size_t(r)][std::size_t(c)] = double(t.m_fFields[r][c]);
  return a;
}

Affine operator*(const Affine& a, const Affine& b) {
  Affine product;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c) {
      product[r][c] = c == 3 ? a[r][3] : 0.0;
      for (std::size_t k = 0; k < 3; ++k) product[r][c] += a[r][k] * b[k][c];
    }
  return product;
}

class Reader {
 public:
  Reader(Bytes bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  MeshData read() {
    model_ = get([](Handle* out) { return lib3mf_createmodel(out); }, nullptr);
    Owned reader =
        get([&](Handle* out) { return lib3mf_model_queryreader(model_.get(), "3mf", out); }, model_.get());
    // lib3mf reads only, though its argument is not const.
    auto* data = reinterpret_cast<BYTE*>(const_cast<std::byte*>(bytes_.data()));
    check(lib3mf_reader_readfrombuffer(reader.get(), data, bytes_.size()), reader.get());
    DWORD warnings = 0, unit = 0;
    check(lib3mf_reader_getwarningcount(reader.get(), &warnings), reader.get());
    if (warnings > 0) data_.defects.push_back(fmt::format("lib3mf gives {} warnings", warnings));
    check(lib3mf_model_getunit(model_.get(), &unit), model_.get());
    static constexpr double kMm[] = {0.001, 1.0, 10.0, 25.4, 304.8, 1000.0};  // in the order of eModelUnit
    if (unit >= std::size(kMm)) fail("an unknown unit");
    data_.format = "3MF";
    data_.mm_per_unit = kMm[unit];
    items();
    if (not_printed_)
      data_.defects.push_back(fmt::format("{} objects of type other are not printed", not_printed_));
    return std::move(data_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw UsageError(name_ + ": " + problem); }

  void check(LIB3MFRESULT result, Handle of) const {
    if (result == LIB3MF_OK) return;
    DWORD code = 0;
    LPCSTR text = nullptr;
    const bool told = of && lib3mf_getlasterror(of, &code, &text) == LIB3MF_OK && text;
    fail(fmt::format("is no 3MF file that lib3mf can read: {} (0x{:x})", told ? text : "no reason given",
                     told ? code : DWORD(result)));
  }
  template <class Call>
  Owned get(const Call& call, Handle of) const {
    Handle out = nullptr;
    check(call(&out), of);
    return Owned(out);
  }

  void items() {
    Owned iterator =
        get([&](Handle* out) { return lib3mf_model_getbuilditems(model_.get(), out); }, model_.get());
    for (BOOL more = 0;
         check(lib3mf_builditemiterator_movenext(iterator.get(), &more), iterator.get()), more;) {
      Owned item = get([&](Handle* out) { return lib3mf_builditemiterator_getcurrent(iterator.get(), out); },
                       iterator.get());
      Owned object =
          get([&](Handle* out) { return lib3mf_builditem_getobjectresource(item.get(), out); }, item.get());
      MODELTRANSFORM t{};
      BOOL moved = 0;
      check(lib3mf_builditem_hasobjecttransform(item.get(), &moved), item.get());
      if (moved) check(lib3mf_builditem_getobjecttransform(item.get(), &t), item.get());
      place(object.get(), moved ? from(t) : kIdentity, 0);
    }
  }

  void place(Handle object, const Affine& at, int depth) {
    if (depth > kMaxComponentDepth)
      fail(fmt::format("components within components, more than {} deep", kMaxComponentDepth));
    if (++placements_ > kMaxPlacements) fail(fmt::format("more than {} placed objects", kMaxPlacements));
    DWORD type = 0;
    check(lib3mf_object_gettype(object, &type), object);
    if (type == MODELOBJECTTYPE_OTHER) {  // 3MF core specification 1.2, 4.1: consumers pass such objects over
      ++not_printed_;
      return;
    }
    BOOL is_mesh = 0, is_components = 0;
    check(lib3mf_object_ismeshobject(object, &is_mesh), object);
    if (is_mesh) return add_mesh(object, at);
    check(lib3mf_object_iscomponentsobject(object, &is_components), object);
    if (!is_components) return;
    DWORD count = 0;
    check(lib3mf_componentsobject_getcomponentcount(object, &count), object);
    for (DWORD n = 0; n < count; ++n) {
      Owned component =
          get([&](Handle* out) { return lib3mf_componentsobject_getcomponent(object, n, out); }, object);
      Owned inner = get([&](Handle* out) { return lib3mf_component_getobjectresource(component.get(), out); },
                        component.get());
      MODELTRANSFORM t{};
      check(lib3mf_component_gettransform(component.get(), &t), component.get());
      place(inner.get(), at * from(t), depth + 1);
    }
  }

  void add_mesh(Handle mesh, const Affine& at) {
    DWORD vertices = 0, triangles = 0;
    check(lib3mf_meshobject_getvertexcount(mesh, &vertices), mesh);
    check(lib3mf_meshobject_gettrianglecount(mesh, &triangles), mesh);
    const std::size_t v0 = data_.vertices.size(), t0 = data_.triangles.size();
    if (v0 + vertices > 0xffffffffu || t0 + triangles > kMaxFacets)
      fail(fmt::format("more facets than the limit of {}", kMaxFacets));
    static_assert(sizeof(MODELMESHVERTEX) == sizeof(slice::Corner) && sizeof(MODELMESHTRIANGLE) == 12);
    data_.vertices.resize(v0 + vertices);
    data_.triangles.resize(t0 + triangles);
    if (vertices)
      check(lib3mf_meshobject_getvertices(mesh, reinterpret_cast<MODELMESHVERTEX*>(&data_.vertices[v0]),
                                          vertices, nullptr),
            mesh);
    if (triangles)
      check(lib3mf_meshobject_gettriangleindices(
                mesh, reinterpret_cast<MODELMESHTRIANGLE*>(&data_.triangles[t0]), triangles, nullptr),
            mesh);
    for (std::size_t v = v0; v < data_.vertices.size(); ++v) {
      const slice::Corner p = data_.vertices[v];
      for (std::size_t r = 0; r < 3; ++r)
        data_.vertices[v][r] =
            float(at[r][0] * double(p[0]) + at[r][1] * double(p[1]) + at[r][2] * double(p[2]) + at[r][3]);
    }
    for (std::size_t t = t0; t < data_.triangles.size(); ++t)
      for (std::uint32_t& corner : data_.triangles[t]) {
        if (corner >= vertices)
          fail(fmt::format("a triangle names vertex {}; its mesh has {}", corner, vertices));
        corner += std::uint32_t(v0);
      }
  }

  Bytes bytes_;
  const std::string& name_;
  Owned model_;
  MeshData data_;
  std::size_t placements_ = 0, not_printed_ = 0;
};

// A model of 8 million facets takes lib3mf some 20 s and 2 GiB; its archive has some 100 MB.
ChildLimits limits_of(std::size_t file_bytes) {
  const std::size_t mb = file_bytes >> 20;
  return {int(5 + std::min<std::size_t>(2 * mb, 3600)),
          (std::size_t(512) << 20) + std::min<std::size_t>(file_bytes, std::size_t(1) << 30) * 64};
}

}  // namespace

MeshData read_3mf(Bytes bytes, const std::string& name) {
  const ChildLimits limits = limits_of(bytes.size());
  MeshData data;
  const auto send = [&](int fd) {
    try {
      check_3mf_package(bytes, name);
      send_mesh(fd, Reader(bytes, name).read());
    } catch (const UsageError& e) {
      send_problem(fd, e.what());
    }
  };
  const auto receive = [&](int fd) { data = receive_mesh(fd, limits.memory_bytes); };
  std::string problem;
  try {
    problem = run_bounded(limits, send, receive);
  } catch (const UsageError&) {
    throw;
  } catch (const std::runtime_error& e) {
    throw UsageError(name + ": cannot be read by lib3mf: " + e.what());
  }
  if (!problem.empty())
    throw UsageError(
        fmt::format("{}: lib3mf cannot read this file of {} bytes: it {}", name, bytes.size(), problem));
  return data;
}

}  // namespace firn::mesh
