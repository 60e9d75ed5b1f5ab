// Stand-ins for what the plugin uses of Unreal, so that it compiles and runs in a test. Names and parameters are the
// engine's; everything else is as short as it can be. HAL/Event.h, HAL/Runnable*.h and Live Link's were checked against
// Unreal's sources (5.3.1; LiveLinkTypes.h and ILiveLinkClient.h of 5.2; ILiveLinkSource.h and LiveLinkSource*.h of 5.8
// too), the others against code that uses them.
//
//     stub                                   stands for, below Engine/Source/Runtime
//     CoreMinimal.h                          Core/Public/CoreMinimal.h and what it includes: containers, mathematics,
//                                            logging, and the macros of CoreUObject/Public/UObject/ObjectMacros.h
//     HAL/*, Misc/*, Modules/*, Templates/*  Core/Public, under the same names
//     UObject/SoftObjectPath.h               CoreUObject/Public/UObject/SoftObjectPath.h
//     Engine/EngineTypes.h                   Engine/Classes/Engine/EngineTypes.h
//     BonePose.h                             Engine/Public/BonePose.h, BoneContainer.h, BoneIndices.h
//     ILiveLink*.h, LiveLinkSource*.h        LiveLinkInterface/Public, under the same names
//     LiveLinkTypes.h, Roles/*               LiveLinkInterface/Public, under the same names
//     LiveLinkRetargetAsset.h                LiveLinkAnimationCore/Public/LiveLinkRetargetAsset.h
//     *.generated.h                          what UnrealHeaderTool writes; empty
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

// Macros of the engine and of windows.h that motionsplice.hpp must survive.
#define near
#define check(expression) static_cast<void>(expression)
#define verify(expression) static_cast<void>(expression)
#define ensure(expression) (expression)
#define PI (3.1415926535897932f)
#define UI UI_is_a_macro
#define TEXT(text) u##text

#define THIRD_PARTY_INCLUDES_START
#define THIRD_PARTY_INCLUDES_END
#define MOTIONSPLICE_API
#define UENUM(...)
#define USTRUCT(...)
#define UCLASS(...)
#define UPROPERTY(...)
#define GENERATED_BODY() \
public: \
	static UClass* StaticClass() \
	{ \
		static UClass Class; \
		return &Class; \
	}

using TCHAR = char16_t;
using ANSICHAR = char;
using uint8 = std::uint8_t;
using uint32 = std::uint32_t;
using int32 = std::int32_t;
constexpr int32 INDEX_NONE = -1;

template <class T> std::remove_reference_t<T>&& MoveTemp(T&& Value) { return std::move(Value); }
template <class T> void Swap(T& A, T& B) { std::swap(A, B); }

std::u16string Utf16(const std::string& Utf8);
std::string Utf8(const std::u16string& Utf16);
#define UTF8_TO_TCHAR(text) Utf16(text).c_str()
#define TCHAR_TO_UTF8(text) Utf8(text).c_str()

class FString
{
public:
	FString() = default;
	FString(const TCHAR* InText) : Text(InText) {}
	template <class... T> static FString Printf(const TCHAR* Format, T... Values)
	{
		FString Printed(Format);
		for (const TCHAR* Value : {Values...})
		{
			Printed.Text.replace(Printed.Text.find(TEXT("%s")), 2, Value);
		}
		return Printed;
	}
	const TCHAR* operator*() const { return Text.c_str(); }
	bool IsEmpty() const { return Text.empty(); }
	friend FString operator/(const FString& A, const FString& B) { return (A.Text + TEXT("/") + B.Text).c_str(); }
	friend bool operator!=(const FString& A, const FString& B) { return A.Text != B.Text; }

private:
	std::u16string Text;
};

class FName
{
public:
	FName(const TCHAR* InText) : Text(InText) {}
	FString ToString() const { return Text; }
	friend bool operator==(const FName& A, const FName& B) { return !(A.Text != B.Text); }
	friend bool operator!=(const FName& A, const FName& B) { return A.Text != B.Text; }

private:
	FString Text;
};

class FText
{
public:
	static FText FromString(const FString& String) { FText Text; Text.Text = String; return Text; }
	const FString& ToString() const { return Text; }

private:
	FString Text;
};
#define LOCTEXT(key, text) FText::FromString(TEXT(text))

template <class T> class TArray
{
public:
	void Add(const T& Element) { Elements.push_back(Element); }
	void SetNum(int32 Count) { Elements.resize(static_cast<std::size_t>(Count)); }
	int32 Num() const { return static_cast<int32>(Elements.size()); }
	T* GetData() { return Elements.data(); }
	const T* GetData() const { return Elements.data(); }
	T& Last() { return Elements.back(); }
	T& operator[](int32 At) { return Elements.at(static_cast<std::size_t>(At)); }
	const T& operator[](int32 At) const { return Elements.at(static_cast<std::size_t>(At)); }
	auto begin() const { return Elements.begin(); }
	auto end() const { return Elements.end(); }

private:
	std::vector<T> Elements;
};

template <class T> class TSharedPtr : public std::shared_ptr<T>
{
public:
	using std::shared_ptr<T>::shared_ptr;
	T* Get() const { return this->get(); }
	void Reset() { this->reset(); }
};
template <class T> TSharedPtr<T> MakeShared() { return TSharedPtr<T>(new T()); }

struct FGuid
{
	int32 A = 0;
};

struct FVector
{
	double X = 0.0, Y = 0.0, Z = 0.0;
	static const FVector UpVector;

	FVector() = default;
	FVector(double InX, double InY, double InZ) : X(InX), Y(InY), Z(InZ) {}
	FVector operator*(double S) const { return {X * S, Y * S, Z * S}; }
	FVector operator+(const FVector& V) const { return {X + V.X, Y + V.Y, Z + V.Z}; }
	FVector operator-(const FVector& V) const { return {X - V.X, Y - V.Y, Z - V.Z}; }
	FVector operator^(const FVector& V) const { return {Y * V.Z - Z * V.Y, Z * V.X - X * V.Z, X * V.Y - Y * V.X}; }
};
inline const FVector FVector::UpVector(0.0, 0.0, 1.0);

struct FQuat
{
	double X = 0.0, Y = 0.0, Z = 0.0, W = 1.0;

	FQuat() = default;
	FQuat(double InX, double InY, double InZ, double InW) : X(InX), Y(InY), Z(InZ), W(InW) {}
	FQuat(const FVector& Axis, double Angle) : W(std::cos(Angle / 2.0))
	{
		const FVector V = Axis * std::sin(Angle / 2.0);
		X = V.X, Y = V.Y, Z = V.Z;
	}
	FQuat Inverse() const { return {-X, -Y, -Z, W}; }
	FQuat operator*(const FQuat& Q) const
	{
		return {W * Q.X + X * Q.W + Y * Q.Z - Z * Q.Y, W * Q.Y - X * Q.Z + Y * Q.W + Z * Q.X,
			W * Q.Z + X * Q.Y - Y * Q.X + Z * Q.W, W * Q.W - X * Q.X - Y * Q.Y - Z * Q.Z};
	}
	FVector RotateVector(const FVector& V) const
	{
		const FVector Q(X, Y, Z), T = (Q ^ V) * 2.0;
		return V + T * W + (Q ^ T);
	}
};

/** A * B is first A, then B, as in the engine. Scales here are uniform. */
class FTransform
{
public:
	static const FTransform Identity;

	FTransform() = default;
	FTransform(const FQuat& InRotation, const FVector& InTranslation, const FVector& InScale = FVector(1.0, 1.0, 1.0))
		: Rotation(InRotation), Translation(InTranslation), Scale(InScale)
	{
	}
	FQuat GetRotation() const { return Rotation; }
	FVector GetTranslation() const { return Translation; }
	void SetRotation(const FQuat& In) { Rotation = In; }
	void SetTranslation(const FVector& In) { Translation = In; }
	FVector TransformPosition(const FVector& V) const { return Rotation.RotateVector(V * Scale.X) + Translation; }
	FVector InverseTransformPosition(const FVector& V) const
	{
		return Rotation.Inverse().RotateVector(V - Translation) * (1.0 / Scale.X);
	}
	FTransform operator*(const FTransform& B) const
	{
		return {B.Rotation * Rotation, B.TransformPosition(Translation), Scale * B.Scale.X};
	}

private:
	FQuat Rotation;
	FVector Translation, Scale{1.0, 1.0, 1.0};
};
inline const FTransform FTransform::Identity;

struct FMath
{
	static double Clamp(double Value, double Least, double Most) { return std::fmin(std::fmax(Value, Least), Most); }
	static int32 Min(int32 A, int32 B) { return A < B ? A : B; }
	static double FloorToDouble(double Value) { return std::floor(Value); }
	static int32 CeilToInt(double Value) { return static_cast<int32>(std::ceil(Value)); }
	static double DegreesToRadians(double Degrees) { return Degrees * (3.141592653589793 / 180.0); }
};

/** Writes a line of the log. */
void Log(const FString& Line);
#define DEFINE_LOG_CATEGORY_STATIC(...)
#define UE_LOG(category, verbosity, ...) Log(FString::Printf(__VA_ARGS__))

class UClass
{
};
class UObject
{
	GENERATED_BODY()
	virtual ~UObject() = default;
};
template <class T> class TSubclassOf
{
public:
	TSubclassOf(UClass* InClass) : Class(InClass) {}
	UClass* Get() const { return Class; }

private:
	UClass* Class;
};
template <class To, class From> const To* CastChecked(const From* Object) { return static_cast<const To*>(Object); }
struct FPropertyChangedEvent
{
};
