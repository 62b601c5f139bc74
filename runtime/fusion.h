// How a fusion is written: one kernel that stands for several neighbouring stages of a segment,
// where that is faster than handing batches from one to the next. It is a struct like a stage's
// (runtime/node.h), with `batch` and maybe `Scratch`; its `declare` says
//   part    the node types it stands for, in the order of the stream, each of them once
//   inner   which output goes to which inputs among them; nobody else may read it
//   in, out what is left of their ports, under names of its own
//   param   the parameters it takes from them
// and it may have `bool suits() const`: whether it can do what these parameters ask for.
// The planner puts it in the place of every group of nodes that is wired that way and of which
// nothing inside is tapped (`weft plan` shows it, --no-fuse leaves it out). The result must be the
// one of the stages, within rounding; a test holds the two together.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/node.h"

namespace weft {

struct FusionDecl {
    struct End {
        size_t part = 0;
        std::string port;
    };
    struct Port {
        std::string name;
        std::vector<End> ends;  // of an input: all ports that read it; of an output: the one it is
    };
    std::string name, about;
    std::vector<std::string> parts;  // node types
    std::vector<std::pair<End, End>> inner;
    std::vector<Port> inputs, outputs;
};

class FusionType {
  public:
    virtual ~FusionType() = default;
    const FusionDecl& decl() const { return decl_; }
    // For nodes of decl().parts; null where their parameters do not suit it.
    virtual std::unique_ptr<NodeInstance> make(
        const std::vector<const GraphNode*>& parts) const = 0;

  protected:
    FusionDecl decl_;
};

namespace detail {
FusionDecl::End end_named(const FusionDecl& decl, const std::string& name);
const Json& parameter(const GraphNode& node, const std::string& name);
size_t choice_of(const GraphNode& node, const std::string& name, const Json& value);
}  // namespace detail

template <class Node>
class Fusing {
  public:
    using Setter = std::function<void(Node&, const std::vector<const GraphNode*>&)>;
    Fusing(FusionDecl& decl, std::vector<Setter>& setters) : decl_(decl), setters_(setters) {}

    Fusing& about(std::string text) {
        decl_.about = std::move(text);
        return *this;
    }
    Fusing& part(std::string type) {
        decl_.parts.push_back(std::move(type));
        return *this;
    }
    // Ports and parameters are named "type.port".
    Fusing& inner(const std::string& from, const std::vector<std::string>& to) {
        for (const std::string& end : to)
            decl_.inner.emplace_back(detail::end_named(decl_, from), detail::end_named(decl_, end));
        return *this;
    }
    Fusing& in(std::string name, const std::vector<std::string>& ends) {
        FusionDecl::Port port{std::move(name), {}};
        for (const std::string& end : ends) port.ends.push_back(detail::end_named(decl_, end));
        decl_.inputs.push_back(std::move(port));
        return *this;
    }
    Fusing& out(std::string name, const std::string& end) {
        decl_.outputs.push_back({std::move(name), {detail::end_named(decl_, end)}});
        return *this;
    }
    template <class T>
    Fusing& param(const std::string& name, T Node::*field) {
        const FusionDecl::End from = detail::end_named(decl_, name);
        setters_.push_back([from, field](Node& node, const std::vector<const GraphNode*>& parts) {
            const Json& value = detail::parameter(*parts[from.part], from.port);
            if constexpr (std::is_enum_v<T>)
                node.*field = T(detail::choice_of(*parts[from.part], from.port, value));
            else
                detail::read(value, node.*field);
        });
        return *this;
    }

  private:
    FusionDecl& decl_;
    std::vector<Setter>& setters_;
};

template <class Node>
class FusionTypeOf final : public FusionType {
  public:
    explicit FusionTypeOf(std::string name) {
        decl_.name = std::move(name);
        Fusing<Node> fusing(decl_, setters_);
        Node::declare(fusing);
    }
    std::unique_ptr<NodeInstance> make(const std::vector<const GraphNode*>& parts) const override {
        static_assert(NodeOf<Node>::form_of() == Form::stage);
        auto instance = std::make_unique<NodeOf<Node>>();
        for (const auto& set : setters_) set(instance->node, parts);
        if constexpr (requires { instance->node.suits(); })
            if (!instance->node.suits()) return nullptr;
        return instance;
    }

  private:
    std::vector<typename Fusing<Node>::Setter> setters_;
};

bool register_fusion(std::unique_ptr<FusionType> type);

}  // namespace weft

#define WEFT_FUSION(Type, Name)                                 \
    [[maybe_unused]] static const bool weft_registered_##Type = \
        ::weft::register_fusion(std::make_unique<::weft::FusionTypeOf<Type>>(Name));
