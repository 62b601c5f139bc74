// Runs one value node by its type's name, without a graph: what a test of a node needs.
#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "runtime/registry.h"

namespace weft {

class RunNode {
  public:
    explicit RunNode(const std::string& type) : type_(Registry::instance().type(type)) {
        if (!type_) throw Error("no node type " + type);
        params_.resize(type_->decl().params.size());
    }
    RunNode& set(const std::string& name, Json value) {
        for (size_t i = 0; i < params_.size(); ++i)
            if (type_->decl().params[i].name == name) {
                params_[i] = std::move(value);
                return *this;
            }
        throw Error("no parameter " + name);
    }
    template <class T>
    RunNode& in(const std::string& port, const T& value, const std::string& name = "node") {
        const int index = type_->decl().find_input(port);
        if (index < 0) throw Error("no input " + port);
        auto& linked = linked_[type_->decl().inputs[size_t(index)].name];
        linked.objects.push_back(const_cast<T*>(&value));
        linked.names.push_back(name);
        linked.type = &type_info<T>();
        return *this;
    }
    // Runs it and returns what stands at `port`.
    template <class T>
    T out(const std::string& port) {
        T result;
        run({Slot{port, &type_info<T>(), &result, {}}});
        return result;
    }
    void run(std::vector<Slot> outputs = {}) {
        Inputs inputs;
        for (auto& [port, linked] : linked_) {
            inputs.slots.push_back({port, linked.type, linked.objects.front(), linked.objects});
            inputs.linked.emplace_back(port, linked.names);
        }
        Outputs out;
        out.slots = std::move(outputs);
        type_->make(params_)->run(inputs, out, ctx);
    }

    PlainContext ctx;

  private:
    struct Linked {
        const TypeInfo* type = nullptr;
        std::vector<void*> objects;
        std::vector<std::string> names;
    };
    const NodeType* type_;
    std::vector<Json> params_;
    std::map<std::string, Linked> linked_;
};

// A folder of the test's own, removed at its end.
class TestFolder {
  public:
    TestFolder() {
        std::string name = testing::TempDir() + "weft-XXXXXX";
        if (!mkdtemp(name.data())) throw Error("no temporary folder");
        path_ = name;
    }
    ~TestFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::string operator/(const std::string& file) const { return path_ + "/" + file; }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

// The message of the Error that `work` throws; "" where it throws none.
template <class Work>
std::string error_of(Work&& work) {
    try {
        work();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

}  // namespace weft
