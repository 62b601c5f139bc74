// How a node is written. A node type is a struct: its fields are the parameters, their initialisers
// the defaults, `declare` the table that everything else is made from. It has one of four forms:
//
//   value   void run(const Inputs&, Outputs&, Context&) const
//   source  Extent extent(const Inputs&) const
//           bool next(const Inputs&, size_t index, Outputs&) const        batch `index` of in.tile(); false: no more
//   stage   void batch(const Inputs&, Outputs&) const                     one batch in, one out
//   sink    using Result = ...;                                           what a whole run fills
//           void open(const Inputs&, const Extent&, Result&) const        before the first tile
//           void batch(const Inputs&, Scratch&) const                     one batch of a tile
//           void end(const Inputs&, Scratch&, Result&) const              a tile is done; tiles are disjoint
//           void close(const Inputs&, Result&, Outputs&, Context&) const  after the last
//
// A source or stage may have `struct Scratch` and take a `Scratch&` as last argument: the worker's
// own, kept from batch to batch. A sink always has one, and may have `void begin(const Inputs&,
// Scratch&) const` for the start of a tile. Any node may have `Cost cost(const Shapes&) const`.
// In a batch inputs are values and batches alike; outputs keep their memory from batch to batch.
// What is wrong with the data is said by throwing Error (or ctx.fail).
//
// Shards (`weft run --shard I/N`, `weft merge`): a sink and a value node may let their work be divided.
//
//   sink    void save(const Inputs&, const Scratch&, ByteWriter& to) const   in a shard, in place of end()
//           void load(const Inputs&, ByteReader& from, Scratch&) const       in the merge, after begin() and before end()
//   value   size_t pieces(const Inputs&) const                               run() is the same as all pieces, joined
//           void piece(const Inputs&, size_t index, ByteWriter& to, Context&) const    one of them
//           void join(const Pieces&, Outputs&, Context&) const               in the merge, in place of run()
//           bool divides() const                                             optional: whether it can, as it is set
//
// A shard I of N makes every N-th tile or piece, in any order, several at once; how many pieces there are and
// what each holds depends on inputs and parameters alone, never on N. The merge has none of the inputs:
// what open, load, end, close or join need of them goes into the bytes, and bit for bit. A merge's
// Scratch lives until close() is done. save(), load() and join() move data; they do not compute.
//
// A node whose result depends on further files than its file parameters (the textures of a scene)
// names them: `std::vector<std::string> reads() const`. They enter its key and the provenance.
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "graph/declaration.h"
#include "runtime/bytes.h"
#include "runtime/context.h"
#include "runtime/value.h"

namespace weft {

// A file parameter. Relative names are relative to the working directory.
struct InputFile {
    std::string path;
};
struct OutputFile {
    std::string path;
};

// Size of what a segment works on, and a tile of it.
struct Extent {
    int width = 0, height = 0;
};
struct Tile {
    size_t index = 0;
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels [x0, x1) x [y0, y1)
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
};

// What is known of a value before it is made (0: not known).
struct Shape {
    std::int64_t width = 0, height = 0, channels = 0, records = 0;
    double bytes = 0;
};
struct Cost {
    std::vector<std::pair<std::string, Shape>> outputs;  // by port
    double scratch_bytes = 0;                            // a worker's own, or while the node runs
    double work = 0;                                     // operations, for progress; 0: not known
};
class Shapes {
  public:
    std::vector<std::pair<std::string_view, Shape>> ports;
    Shape operator[](std::string_view port) const {
        for (const auto& [name, shape] : ports)
            if (name == port) return shape;
        return {};
    }
};

// What stands at one port: an object the runtime owns, by type.
struct Slot {
    std::string_view port;
    const TypeInfo* type = nullptr;
    void* object = nullptr;              // null: not connected
    std::vector<void*> more;             // variadic inputs: all of them, object among them
};

class Inputs {
  public:
    template <class T>
    const T* find(std::string_view port) const {
        const Slot* slot = slot_of(port);
        return slot ? static_cast<const T*>(slot->object) : nullptr;
    }
    template <class T>
    const T& get(std::string_view port) const {
        if (const T* value = find<T>(port)) return *value;
        missing(port);
    }
    template <class T>
    const T& get_or(std::string_view port, const T& other) const {
        const T* value = find<T>(port);
        return value ? *value : other;
    }
    template <class T>
    std::vector<const T*> all(std::string_view port) const {
        std::vector<const T*> values;
        if (const Slot* slot = slot_of(port))
            for (void* object : slot->more) values.push_back(static_cast<const T*>(object));
        return values;
    }
    // Of a variadic port: the names of the nodes linked, in order ("input", "reconstruction").
    const std::vector<std::string>& names(std::string_view port) const;

    const Tile& tile() const { return tile_; }
    const Extent& extent() const { return extent_; }

    // The runtime's side.
    std::vector<Slot> slots;
    std::vector<std::pair<std::string_view, std::vector<std::string>>> linked;
    Tile tile_;
    Extent extent_;

  private:
    const Slot* slot_of(std::string_view port) const {
        for (const Slot& slot : slots)
            if (slot.port == port) return &slot;
        return nullptr;
    }
    [[noreturn]] static void missing(std::string_view port);
};

class Outputs {
  public:
    // The object to fill. A stage finds what it left there a batch ago.
    template <class T>
    T& get(std::string_view port) {
        return *static_cast<T*>(object(port));
    }
    template <class T>
    void set(std::string_view port, T value) {
        get<T>(port) = std::move(value);
    }
    // Whether anybody reads it; what nobody reads need not be made.
    bool wanted(std::string_view port) const {
        for (const Slot& slot : slots)
            if (slot.port == port) return slot.object != nullptr;
        return false;
    }

    std::vector<Slot> slots;  // the runtime's side

  private:
    void* object(std::string_view port) const {
        for (const Slot& slot : slots)
            if (slot.port == port && slot.object) return slot.object;
        missing(port);
    }
    [[noreturn]] static void missing(std::string_view port);
};

enum class Form { value, source, stage, sink };

// One configured node, whatever its form.
class NodeInstance {
  public:
    virtual ~NodeInstance() = default;
    virtual Form form() const = 0;
    virtual Cost cost(const Shapes&) const { return {}; }
    virtual std::shared_ptr<void> make_scratch() const { return nullptr; }
    virtual std::shared_ptr<void> make_result() const { return nullptr; }

    virtual void run(const Inputs&, Outputs&, Context&) const {}
    virtual Extent extent(const Inputs&) const { return {}; }
    virtual bool next(const Inputs&, size_t, Outputs&, void*) const { return false; }
    virtual void batch(const Inputs&, Outputs&, void*) const {}
    virtual void open(const Inputs&, const Extent&, void*) const {}
    virtual void begin(const Inputs&, void*) const {}
    virtual void take(const Inputs&, void*) const {}
    virtual void end(const Inputs&, void*, void*) const {}
    virtual void close(const Inputs&, void*, Outputs&, Context&) const {}

    virtual std::vector<std::string> reads() const { return {}; }
    virtual bool divides() const { return false; }
    virtual void save(const Inputs&, const void*, ByteWriter&) const {}
    virtual void load(const Inputs&, ByteReader&, void*) const {}
    virtual size_t pieces(const Inputs&) const { return 0; }
    virtual void piece(const Inputs&, size_t, ByteWriter&, Context&) const {}
    virtual void join(const Pieces&, Outputs&, Context&) const {}
};

class NodeType {
  public:
    virtual ~NodeType() = default;
    const NodeDecl& decl() const { return decl_; }
    // `params` as decl().params, checked against them; null leaves the default.
    virtual std::unique_ptr<NodeInstance> make(const std::vector<Json>& params) const = 0;

  protected:
    NodeDecl decl_;
};

struct Limits {
    std::string unit = {};
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    std::string about = {};
    bool required = false;  // no default: must be set
};

namespace detail {
void note_type(const TypeInfo&);
void read(const Json&, float&);
void read(const Json&, double&);
void read(const Json&, int&);
void read(const Json&, std::uint64_t&);
void read(const Json&, bool&);
void read(const Json&, std::string&);
void read(const Json&, InputFile&);
void read(const Json&, OutputFile&);
void read(const Json&, std::array<float, 3>&);
void read(const Json&, std::vector<float>&);
void read(const Json&, std::vector<std::string>&);
void read(const Json&, Json&);
ParamDecl declare(float);
ParamDecl declare(double);
ParamDecl declare(int);
ParamDecl declare(std::uint64_t);
ParamDecl declare(bool);
ParamDecl declare(const std::string&);
ParamDecl declare(const InputFile&);
ParamDecl declare(const OutputFile&);
ParamDecl declare(const std::array<float, 3>&);
ParamDecl declare(const std::vector<float>&);
ParamDecl declare(const std::vector<std::string>&);
ParamDecl declare(const Json&);  // an object
}  // namespace detail

// What `declare` fills in.
template <class Node>
class Ports {
  public:
    Ports(NodeDecl& decl, std::vector<std::function<void(Node&, const Json&)>>& setters)
        : decl_(decl), setters_(setters) {}

    Ports& about(std::string text) {
        decl_.about = std::move(text);
        return *this;
    }
    Ports& writes() {
        decl_.writes = true;
        return *this;
    }
    template <class T>
    Ports& in(std::string name, std::string text, Need need = Need::required) {
        detail::note_type(type_info<T>());
        decl_.inputs.push_back({std::move(name), std::move(text), std::string(TypeOf<T>::name), TypeOf<T>::stream, need});
        return *this;
    }
    // Some of the records of the node's first stream, to be merged with it.
    template <class T>
    Ports& in_branch(std::string name, std::string text, Need need = Need::required) {
        in<T>(std::move(name), std::move(text), need);
        decl_.inputs.back().branch = true;
        return *this;
    }
    template <class T>
    Ports& out(std::string name, std::string text) {
        detail::note_type(type_info<T>());
        decl_.outputs.push_back({std::move(name), std::move(text), std::string(TypeOf<T>::name), TypeOf<T>::stream});
        decl_.outputs.back().per_batch = is_per_batch<T>();
        return *this;
    }
    // Passes on some of its input's records; sets the batch's pixels and parents itself.
    template <class T>
    Ports& out_selection(std::string name, std::string text) {
        out<T>(std::move(name), std::move(text));
        decl_.outputs.back().selects = true;
        return *this;
    }
    template <class T>
    Ports& param(std::string name, T Node::* field, Limits limits = {}) {
        ParamDecl p = detail::declare(Node{}.*field);
        if (limits.required) p.fallback.reset();
        add(std::move(p), std::move(name), limits);
        setters_.push_back([field](Node& node, const Json& value) { detail::read(value, node.*field); });
        return *this;
    }
    // "" is allowed and means: no file.
    template <class T>
    Ports& optional_file(std::string name, T Node::* field, Limits limits = {}) {
        param(std::move(name), field, std::move(limits));
        decl_.params.back().optional_file = true;
        return *this;
    }
    // An enum whose values 0, 1, ... are called `names`.
    template <class E>
    Ports& choice(std::string name, E Node::* field, std::vector<std::string> names, Limits limits = {}) {
        ParamDecl p;
        p.kind = Kind::choice;
        p.choices = names;
        if (!limits.required) p.fallback = Json(names.at(size_t(Node{}.*field)));
        add(std::move(p), std::move(name), limits);
        setters_.push_back([field, names](Node& node, const Json& value) {
            for (size_t i = 0; i < names.size(); ++i)
                if (names[i] == value.text) node.*field = E(i);
        });
        return *this;
    }

  private:
    template <class T>
    static constexpr bool is_per_batch() {
        if constexpr (requires { T::per_batch; }) return T::per_batch;
        return false;
    }
    void add(ParamDecl p, std::string name, const Limits& limits) {
        p.name = std::move(name);
        p.about = limits.about;
        p.unit = limits.unit;
        p.minimum = std::max(p.minimum, limits.min);
        p.maximum = std::min(p.maximum, limits.max);
        decl_.params.push_back(std::move(p));
    }
    NodeDecl& decl_;
    std::vector<std::function<void(Node&, const Json&)>>& setters_;
};

// Puts a plain struct behind NodeInstance.
template <class Node>
class NodeOf final : public NodeInstance {
    template <class N>
    static auto scratch_of() {
        if constexpr (requires { typename N::Scratch; })
            return std::type_identity<typename N::Scratch>{};
        else
            return std::type_identity<void>{};
    }
    template <class N>
    static auto result_of() {
        if constexpr (requires { typename N::Result; })
            return std::type_identity<typename N::Result>{};
        else
            return std::type_identity<void>{};
    }
    using Scratch = typename decltype(scratch_of<Node>())::type;
    using Result = typename decltype(result_of<Node>())::type;
    static constexpr bool has_scratch = !std::is_void_v<Scratch>;

  public:
    Node node;

    static constexpr Form form_of() {
        if constexpr (!std::is_void_v<Result>) return Form::sink;
        else if constexpr (requires(const Node& n, const Inputs& in) { n.extent(in); }) return Form::source;
        else if constexpr (requires(const Node& n, const Inputs& in, Outputs& out, Context& ctx) { n.run(in, out, ctx); })
            return Form::value;
        else return Form::stage;
    }
    Form form() const override { return form_of(); }

    Cost cost(const Shapes& in) const override {
        if constexpr (requires { node.cost(in); }) return node.cost(in);
        else return {};
    }
    std::shared_ptr<void> make_scratch() const override {
        if constexpr (has_scratch) return std::make_shared<Scratch>();
        else return nullptr;
    }
    std::shared_ptr<void> make_result() const override {
        if constexpr (form_of() == Form::sink) return std::make_shared<Result>();
        else return nullptr;
    }
    void run(const Inputs& in, Outputs& out, Context& ctx) const override {
        if constexpr (form_of() == Form::value) node.run(in, out, ctx);
    }
    Extent extent(const Inputs& in) const override {
        if constexpr (form_of() == Form::source) return node.extent(in);
        else return {};
    }
    bool next(const Inputs& in, size_t index, Outputs& out, [[maybe_unused]] void* scratch) const override {
        if constexpr (form_of() == Form::source) {
            if constexpr (has_scratch) return node.next(in, index, out, *static_cast<Scratch*>(scratch));
            else return node.next(in, index, out);
        } else return false;
    }
    void batch(const Inputs& in, Outputs& out, [[maybe_unused]] void* scratch) const override {
        if constexpr (form_of() == Form::stage) {
            if constexpr (has_scratch) node.batch(in, out, *static_cast<Scratch*>(scratch));
            else node.batch(in, out);
        }
    }
    void open(const Inputs& in, const Extent& extent, void* result) const override {
        if constexpr (form_of() == Form::sink) node.open(in, extent, *static_cast<Result*>(result));
    }
    void begin([[maybe_unused]] const Inputs& in, [[maybe_unused]] void* scratch) const override {
        if constexpr (form_of() == Form::sink)
            if constexpr (requires(Scratch& s) { node.begin(in, s); })
                node.begin(in, *static_cast<Scratch*>(scratch));
    }
    void take(const Inputs& in, void* scratch) const override {
        if constexpr (form_of() == Form::sink) node.batch(in, *static_cast<Scratch*>(scratch));
    }
    void end(const Inputs& in, void* scratch, void* result) const override {
        if constexpr (form_of() == Form::sink)
            node.end(in, *static_cast<Scratch*>(scratch), *static_cast<Result*>(result));
    }
    void close(const Inputs& in, void* result, Outputs& out, Context& ctx) const override {
        if constexpr (form_of() == Form::sink) node.close(in, *static_cast<Result*>(result), out, ctx);
    }

    std::vector<std::string> reads() const override {
        if constexpr (requires { node.reads(); }) return node.reads();
        else return {};
    }
    static constexpr bool can_divide() {
        if constexpr (form_of() == Form::sink)
            return requires(const Node& n, const Inputs& in, Scratch& s, ByteWriter& to, ByteReader& from) {
                n.save(in, s, to);
                n.load(in, from, s);
            };
        else
            return requires(const Node& n, const Inputs& in, ByteWriter& to, const Pieces& all, Outputs& out, Context& ctx) {
                n.pieces(in);
                n.piece(in, size_t{}, to, ctx);
                n.join(all, out, ctx);
            };
    }
    bool divides() const override {
        if constexpr (can_divide() && requires { node.divides(); }) return node.divides();
        else return can_divide();
    }
    void save([[maybe_unused]] const Inputs& in, [[maybe_unused]] const void* scratch, [[maybe_unused]] ByteWriter& to) const override {
        if constexpr (form_of() == Form::sink && can_divide()) node.save(in, *static_cast<const Scratch*>(scratch), to);
    }
    void load([[maybe_unused]] const Inputs& in, [[maybe_unused]] ByteReader& from, [[maybe_unused]] void* scratch) const override {
        if constexpr (form_of() == Form::sink && can_divide()) node.load(in, from, *static_cast<Scratch*>(scratch));
    }
    size_t pieces([[maybe_unused]] const Inputs& in) const override {
        if constexpr (form_of() == Form::value && can_divide()) return node.pieces(in);
        else return 0;
    }
    void piece([[maybe_unused]] const Inputs& in, [[maybe_unused]] size_t index, [[maybe_unused]] ByteWriter& to,
               [[maybe_unused]] Context& ctx) const override {
        if constexpr (form_of() == Form::value && can_divide()) node.piece(in, index, to, ctx);
    }
    void join([[maybe_unused]] const Pieces& all, [[maybe_unused]] Outputs& out, [[maybe_unused]] Context& ctx) const override {
        if constexpr (form_of() == Form::value && can_divide()) node.join(all, out, ctx);
    }
};

template <class Node>
class NodeTypeOf final : public NodeType {
  public:
    NodeTypeOf(std::string type, int version, std::string family) {
        decl_.type = std::move(type);
        decl_.version = version;
        decl_.family = std::move(family);
        Ports<Node> ports(decl_, setters_);
        Node::declare(ports);
    }
    std::unique_ptr<NodeInstance> make(const std::vector<Json>& params) const override {
        auto instance = std::make_unique<NodeOf<Node>>();
        for (size_t i = 0; i < params.size() && i < setters_.size(); ++i)
            if (!params[i].is(Json::Kind::null)) setters_[i](instance->node, params[i]);
        return instance;
    }

  private:
    std::vector<std::function<void(Node&, const Json&)>> setters_;
};

// Adds a node type to the registry; of two of the same name the first stays and the second is
// reported by Registry::conflicts().
bool register_node(std::unique_ptr<NodeType> type);

// The folder a source file lies in, for the family's name: ".../nodes/filters/x.cpp" -> "filters".
std::string family_of(std::string_view file);

}  // namespace weft

// The version is part of every key: raise it when results change.
#define WEFT_NODE(Type, Name, Version)                                                      \
    [[maybe_unused]] static const bool weft_registered_##Type = ::weft::register_node(       \
        std::make_unique<::weft::NodeTypeOf<Type>>(Name, Version, ::weft::family_of(__FILE__)));
