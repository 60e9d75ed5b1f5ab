#pragma once
#include <chrono>
#include <condition_variable>

#include "CoreMinimal.h"

/** Resets itself when a wait ends. */
class FEvent
{
public:
	void Trigger()
	{
		const std::lock_guard<std::mutex> Guard(Mutex);
		bTriggered = true;
		Condition.notify_one();
	}
	bool Wait(uint32 Milliseconds)
	{
		std::unique_lock<std::mutex> Guard(Mutex);
		// wait_until of the system's clock, because ThreadSanitizer does not know the call behind wait_for
		const auto End = std::chrono::system_clock::now() + std::chrono::milliseconds(Milliseconds);
		Condition.wait_until(Guard, End, [this] { return bTriggered; });
		return std::exchange(bTriggered, false);
	}
	bool Wait()
	{
		std::unique_lock<std::mutex> Guard(Mutex);
		Condition.wait(Guard, [this] { return bTriggered; });
		return std::exchange(bTriggered, false);
	}

private:
	std::mutex Mutex;
	std::condition_variable Condition;
	bool bTriggered = false;
};

class FEventRef
{
public:
	FEvent* operator->() const { return Event.get(); }

private:
	std::unique_ptr<FEvent> Event = std::make_unique<FEvent>();
};
