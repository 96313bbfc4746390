// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/token_proof.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

#include "base/rpc/client.hpp"
#include "tests/base/rpc/running_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base::rpc {
namespace {

constexpr const char* kProvenToken = "correct horse battery staple";

TEST(HmacSha256, IsThatOfRfc4231) {
  EXPECT_EQ(hmac_sha256("Jefe", "what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(hmac_sha256(std::string(131, '\xaa'),
                        "Test Using Larger Than Block-Size Key - Hash Key First"),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

TEST(TokenProof, DependsOnAllThatItIsBoundTo) {
  const ProofContext context{"127.0.0.1:5790", "nonce of the client", "nonce of the server"};
  const std::string proof = token_proof(kProvenToken, Prover::kServer, context);
  EXPECT_EQ(proof.size(), 64U);
  EXPECT_EQ(token_proof(kProvenToken, Prover::kServer, context), proof);
  EXPECT_NE(token_proof("another token, also long", Prover::kServer, context), proof);
  EXPECT_NE(token_proof(kProvenToken, Prover::kClient, context), proof);
  for (std::string ProofContext::*part :
       {&ProofContext::endpoint, &ProofContext::client_nonce, &ProofContext::server_nonce}) {
    ProofContext other = context;
    other.*part += "1";
    EXPECT_NE(token_proof(kProvenToken, Prover::kServer, other), proof);
  }
}

TEST(TokenProof, EachNonceIsAnother) { EXPECT_NE(make_nonce(), make_nonce()); }

class ProvenClient : public testing::Test {
 protected:
  ProvenClient() {
    const auto file = folder_.write("token", kProvenToken);
    ::chmod(file.c_str(), 0600);
    server_.run([&] { server_.server().require_token(file); });
  }

  test::TemporaryFolder folder_;
  RunningServer server_;
};

TEST_F(ProvenClient, IsAuthorisedByOneOfItsTokens) {
  Client client(server_.address());
  EXPECT_TRUE(client.authorise_by_proof({"the token of another server", kProvenToken}));
  EXPECT_EQ(client.call("echo", {1}, kPatience), Json({1}));
}

TEST_F(ProvenClient, IsNotAuthorisedWithoutTheToken) {
  Client client(server_.address());
  EXPECT_FALSE(client.authorise_by_proof({"the token of another server"}));
  EXPECT_THROW(client.call("echo", {1}, kPatience), CallError);
  // A proof that it made up ends the connection, as a wrong token does.
  EXPECT_THROW(client.call("authorise", {{"proof", std::string(64, '0')}}, kPatience), CallError);
  EXPECT_THROW(client.call("echo", {1}, kPatience), ConnectionError);
}

TEST_F(ProvenClient, GetsNowhereWithAProofBeforeTheNonces) {
  Client client(server_.address());
  const std::string proof = token_proof(kProvenToken, Prover::kClient, {server_.address(), "", ""});
  EXPECT_THROW(client.call("authorise", {{"proof", proof}}, kPatience), CallError);
  EXPECT_TRUE(server_.wait_for_refused(Refusal::kWrongToken, 1));
}

TEST_F(ProvenClient, GetsNowhereWithWhatTheServerSaid) {
  Client client(server_.address());
  const Json hello = client.call("authorise", {{"nonce", make_nonce()}}, kPatience);
  EXPECT_THROW(client.call("authorise", {{"proof", hello["proof"]}}, kPatience), CallError);
}

TEST_F(ProvenClient, IsAnsweredWhateverTypesItSends) {
  const std::string nonce(32, 'n');
  for (const Json& token : {Json(5), Json(nullptr), Json::array(), Json::object()}) {
    for (const Json& rest :
         {Json{{"proof", "x"}}, Json{{"proof", token}}, Json{{"nonce", token}}}) {
      Json params = rest;
      params["token"] = token;
      Client client(server_.address());
      EXPECT_THROW(client.call("authorise", params, kPatience), CallError) << params;
    }
  }
  Client other(server_.address());
  EXPECT_TRUE(
      other.call("authorise", {{"token", nullptr}, {"nonce", nonce}}, kPatience).is_object());
  Client client(server_.address());
  EXPECT_TRUE(client.authorise_by_proof({kProvenToken})) << "the server lives";
}

TEST_F(ProvenClient, NeedsANonceThatIsNoGuess) {
  Client client(server_.address());
  EXPECT_THROW(client.call("authorise", {{"nonce", "short"}}, kPatience), CallError);
  EXPECT_TRUE(client.authorise_by_proof({kProvenToken})) << "a bad nonce is no wrong token";
}

}  // namespace
}  // namespace cas::base::rpc
