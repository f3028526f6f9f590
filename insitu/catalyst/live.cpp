// The live connection: every channel is a source of ParaView's server manager here, which a listening ParaView sees as
// the simulation's pipeline, extracts data from, and can add filters to.
//
// The link is synchronous: while the client is slow or hangs, so does this process, and the engine drops live frames.
// What the engine must know is told it: a client has come or gone (LINK), pauses or goes on, or commands (STEER).
#include "catalyst.h"

#include <chrono>
#include <cstdio>
#include <map>
#include <set>
#include <sstream>
#include <sys/socket.h>

#include <vtkPVTrivialProducer.h>
#include <vtkPolyData.h>
#include <vtkSMPropertyHelper.h>
#include <vtkSMProxyIterator.h>
#include <vtkSMSessionProxyManager.h>
#include <vtkSMSourceProxy.h>

#include "channels.h"
#include "engine.h"
#include "live_link.h"
#include "session.h"

namespace
{
constexpr double RETRY = 0.5; // s, between attempts to find a listening ParaView
// A source that every ParaView knows, so that no plugin is needed: its text is where commands are written.
constexpr const char *STEERING = "Steering";
constexpr const char *STEERING_HELP =
	"# One command per line; to repeat one, put a number before it (2 step=10).\n"
	"# pause=1   pause=0   step=10   checkpoint=1   stop=1\n"
	"# inspect.NAME=hottest   inspect.NAME=point:123   inspect.NAME=at:0.5,1.2\n"
	"# images.NAME.every=0.1\n";

double now()
{
	using clock = std::chrono::steady_clock;
	return std::chrono::duration<double>(clock::now().time_since_epoch()).count();
}

class live_task : public task
{
  public:
	live_task(vtkSMSessionProxyManager *manager, const std::string &host, int port) : manager(manager)
	{
		link->SetHostname(host.c_str());
		link->SetInsituPort(port);
		link->SetProcessType(vtkLiveInsituLink::INSITU);
		vtkSMProxy *text = add_source("TextSource", STEERING);
		if (text) {
			vtkSMPropertyHelper(text, "Text").Set(STEERING_HELP);
			text->UpdateVTKObjects();
		}
		remember_commands();
	}

	bool work(const frame_message &request, const frame_view &frame, std::string &) override
	{
		channels next(frame);
		time = frame.header().time;
		step = frame.header().step;
		show(next);
		data = std::move(next); // the former arrays have gone from the sources: their slot can be given back
		if (slot >= 0)
			engine_send(FRAME_MSG_DONE, slot);
		slot = request.slot;
		if (link->connected())
			exchange();
		engine_send(FRAME_MSG_KEPT, slot);
		return true;
	}

	int descriptor() override { return link->connected() ? link->descriptor() : -1; }

	int patience() override
	{
		if (link->connected() || slot < 0)
			return -1;
		double left = next_try - now();
		return left > 0 ? int(1e3 * left) + 1 : 0;
	}

	void attend() override
	{
		if (!link->connected()) {
			seek();
			return;
		}
		// A pause that ends, changes to the pipeline while it lasts, or the end of the connection.
		char byte;
		if (recv(link->descriptor(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0)
			link->DropLiveInsituConnection();
		else
			link->WaitForLiveChange();
		if (link->connected() && paused)
			exchange();
		else
			notice_end();
	}

  private:
	vtkSMProxy *add_source(const char *type, const char *name)
	{
		vtkSmartPointer<vtkSMProxy> proxy = vtkSmartPointer<vtkSMProxy>::Take(manager->NewProxy("sources", type));
		if (!proxy)
			return nullptr;
		proxy->UpdateVTKObjects();
		manager->RegisterProxy("sources", name, proxy);
		return proxy;
	}

	// The channels are what the sources produce; a source whose channel has gone (no wall stands now) is empty.
	void show(const channels &frame)
	{
		std::set<std::string> here;
		for (const auto &channel : frame.all()) {
			here.insert(channel.name);
			vtkSMProxy *&source = sources[channel.name];
			if (!source)
				source = add_source("PVTrivialProducer", channel.name.c_str());
			produce(source, channel.data);
		}
		vtkNew<vtkPolyData> nothing;
		for (auto &source : sources)
			if (!here.count(source.first))
				produce(source.second, nothing);
	}

	void produce(vtkSMProxy *source, vtkDataObject *data)
	{
		auto *producer = source ? vtkPVTrivialProducer::SafeDownCast(source->GetClientSideObject()) : nullptr;
		if (!producer)
			return;
		producer->SetOutput(data, time);
		source->MarkModified(source);
	}

	// Looks whether a ParaView listens.
	void seek()
	{
		double start = now();
		link->Initialize(manager);
		double took = now() - start;
		next_try = now() + std::max(RETRY, 4 * took); // a host that answers slowly is asked rarely
		if (link->connected())
			engine_send(FRAME_MSG_LINK, -1, "", 1);
	}

	// One round of the link: the client's wishes, the pipeline, the data.
	void exchange()
	{
		// Not with warnings switched off: the link knows a broken connection by the errors that it raises.
		link->InsituUpdate(time, step);
		if (link->connected())
			update_sources();
		if (link->connected())
			link->InsituPostProcess(time, step);
		if (!link->connected()) {
			notice_end();
			return;
		}
		set_paused(link->GetSimulationPaused() != 0);
		send_commands();
	}

	void update_sources()
	{
		vtkNew<vtkSMProxyIterator> all;
		all->SetSessionProxyManager(manager);
		all->SetModeToOneGroup();
		for (all->Begin("sources"); !all->IsAtEnd(); all->Next())
			if (auto *source = vtkSMSourceProxy::SafeDownCast(all->GetProxy()))
				source->UpdatePipeline(time);
	}

	void set_paused(bool now)
	{
		if (now != paused)
			engine_send(FRAME_MSG_STEER, -1, now ? "pause=1" : "pause=0");
		paused = now;
	}

	void notice_end()
	{
		if (link->connected())
			return;
		paused = false; // as the engine takes it that a client that has gone pauses nothing
		engine_send(FRAME_MSG_LINK, -1, "", 0);
		next_try = now() + RETRY;
	}

	std::multiset<std::string> command_lines() const
	{
		std::multiset<std::string> lines;
		vtkSMProxy *proxy = manager->GetProxy("sources", STEERING);
		std::istringstream text(proxy ? vtkSMPropertyHelper(proxy, "Text").GetAsString() : "");
		for (std::string line; std::getline(text, line);)
			lines.insert(line);
		return lines;
	}

	void remember_commands() { commands = command_lines(); }

	// Lines that were not there before, without the number that makes them new, and without comments.
	void send_commands()
	{
		vtkSMProxy *proxy = manager->GetProxy("sources", STEERING);
		std::istringstream text(proxy ? vtkSMPropertyHelper(proxy, "Text").GetAsString() : "");
		std::multiset<std::string> before = commands;
		for (std::string line; std::getline(text, line);) {
			auto known = before.find(line);
			if (known != before.end()) {
				before.erase(known);
				continue;
			}
			std::string command = line.substr(0, line.find('#'));
			size_t from = command.find_first_not_of("0123456789 \t\r");
			size_t to = command.find_last_not_of(" \t\r");
			if (from != std::string::npos)
				engine_send(FRAME_MSG_STEER, -1, command.substr(from, to - from + 1));
		}
		remember_commands();
	}

	vtkSMSessionProxyManager *manager;
	vtkNew<live_link> link;
	std::map<std::string, vtkSMProxy *> sources;
	std::multiset<std::string> commands;
	channels data; // what the sources show
	int slot = -1; // where it lies
	double time = 0, next_try = 0;
	int64_t step = 0;
	bool paused = false;
};
} // namespace

task *live_create(const std::string &host, int port, std::string &error)
{
	vtkSMSessionProxyManager *manager = session_start(error);
	return manager ? new live_task(manager, host, port) : nullptr;
}
